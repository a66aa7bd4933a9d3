#include "dsp/stereo/match_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

namespace stof::dsp {
namespace {

// Nothing but one decimal number in [low, high].
std::optional<int> number(std::string_view text, int low, int high) noexcept {
  int value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc{} && stop == end && value >= low && value <= high ? std::optional(value)
                                                                              : std::nullopt;
}

bool set_number(std::string_view text, int low, int high, int& to) noexcept {
  const std::optional<int> value = number(text, low, high);
  to = value.value_or(to);
  return value.has_value();
}

bool set_limit(std::string_view text, int low, int high, std::optional<int>& to) noexcept {
  const std::optional<int> value = number(text, low, high);
  if (!value && text != "off") {
    return false;
  }
  to = value;
  return true;
}

bool set_switch(std::string_view text, bool& to) noexcept {
  if (text != "on" && text != "off") {
    return false;
  }
  to = text == "on";
  return true;
}

template <typename T>
struct Named {
  std::string_view name;
  T value;
};

template <typename T, std::size_t kCount>
bool set_named(std::string_view text, const std::array<Named<T>, kCount>& names, T& to) noexcept {
  const auto* const found = std::ranges::find(names, text, &Named<T>::name);
  if (found == names.end()) {
    return false;
  }
  to = found->value;
  return true;
}

constexpr std::array<Named<Method>, 4> kMethods{{{"wta", Method::kWinnerTakesAll},
                                                 {"dp", Method::kOrdered},
                                                 {"so", Method::kScanline},
                                                 {"sgm", Method::kSemiGlobal}}};
constexpr std::array<Named<Cost>, 6> kCosts{{{"sad", Cost::kSad},
                                             {"ssd", Cost::kSsd},
                                             {"census5x5", Cost::kCensus5x5},
                                             {"census5", Cost::kCensus5x5},
                                             {"census9x7", Cost::kCensus9x7},
                                             {"mixed", Cost::kMixed}}};
constexpr std::array<Named<BlockShape>, 3> kShapes{{{"fixed", BlockShape::kFixed},
                                                    {"cross", BlockShape::kCross},
                                                    {"region", BlockShape::kRegion}}};
constexpr std::array<Named<Subpixel>, 4> kFits{{{"off", Subpixel::kWhole},
                                                {"equiangular", Subpixel::kEquiangular},
                                                {"parabola", Subpixel::kParabola},
                                                {"least-squares", Subpixel::kLeastSquares}}};
constexpr std::array<Named<std::optional<Interest>>, 3> kInterests{
    {{"off", std::nullopt},
     {"maxima", Interest::kMaxima},
     {"thresholds", Interest::kTwoThresholds}}};

bool set_block(std::string_view text, MatchParams& params) noexcept {
  const std::size_t by = text.find('x');
  if (by == std::string_view::npos) {
    return false;
  }
  const std::optional<int> width = number(text.substr(0, by), 1, kMaxBlock);
  const std::optional<int> height = number(text.substr(by + 1), 1, kMaxBlock);
  if (!width || !height) {
    return false;
  }
  params.block_width = *width;
  params.block_height = *height;
  return true;
}

// P1,P2 or P1,P2,occlusion.
bool set_penalties(std::string_view text, MatchParams& params) noexcept {
  std::array<int, 3> values{};
  std::size_t count = 0;
  while (count < values.size()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    if (!set_number(text.substr(0, comma), 0, kMaxPenalty, values[count])) {
      return false;
    }
    ++count;
    if (comma == text.size()) {
      break;
    }
    text.remove_prefix(comma + 1);
  }
  if (count < 2 || values[0] > values[1]) {
    return false;
  }
  params.smoothness = {.small_step = values[0],
                       .large_step = values[1],
                       .occlusion = count == 3 ? values[2] : values[1] / 2};
  return true;
}

bool set_directions(std::string_view text, MatchParams& params) noexcept {
  int directions = 0;
  if (!set_number(text, 2, 8, directions) ||
      (directions != 2 && directions != 4 && directions != 5 && directions != 8)) {
    return false;
  }
  params.directions = directions;
  return true;
}

using Text = std::string_view;

constexpr std::array<MatchOption, 22> kOptions{{
    {"method", "wta, dp, so or sgm", "search: winner takes all, ordered, scanline, semi-global", "",
     [](Text text, MatchParams& p) { return set_named(text, kMethods, p.method); }},
    {"cost", "sad, ssd, census5x5, census9x7 or mixed", "what two pixels differ by", "",
     [](Text text, MatchParams& p) { return set_named(text, kCosts, p.cost); }},
    {"block", "WxH from 1x1 to 64x64", "block in px", "", set_block},
    {"shape", "fixed, cross or region", "blocks that grow until they meet an edge, up to --block",
     "", [](Text text, MatchParams& p) { return set_named(text, kShapes, p.block_shape); }},
    {"min-disparity", "-1024..1024", "first candidate in px", "",
     [](Text text, MatchParams& p) {
       return set_number(text, -kMaxMinDisparity, kMaxMinDisparity, p.min_disparity);
     }},
    {"prefilter", "1..127 or off", "cap of the derivative that is matched in place of grey values",
     "", [](Text text, MatchParams& p) { return set_limit(text, 1, 127, p.prefilter_cap); }},
    {"smooth", "on or off", "3x3 binomial before anything else", "on",
     [](Text text, MatchParams& p) { return set_switch(text, p.smooth); }},
    {"equalise", "on or off", "bring the right picture to the left one's brightness", "on",
     [](Text text, MatchParams& p) { return set_switch(text, p.equalise); }},
    {"penalties", "P1,P2 or P1,P2,OCCLUSION",
     "cost of a change of disparity by one, by more, in units of one pixel's cost", "",
     set_penalties},
    {"directions", "2, 4, 5 or 8", "paths of the semi-global search", "", set_directions},
    {"band", "0..256 or off", "scanline: px around what winner takes all found nearby", "",
     [](Text text, MatchParams& p) { return set_limit(text, 0, kMaxDisparities, p.band); }},
    {"pyramid", "1, 2 or off", "coarse to fine, from half or a quarter of the size", "2",
     [](Text text, MatchParams& p) { return set_limit(text, 1, 2, p.pyramid_levels); }},
    {"interest", "maxima, thresholds or off", "match only where the derivative stands out",
     "maxima", [](Text text, MatchParams& p) { return set_named(text, kInterests, p.interest); }},
    {"lr", "0..256 or off", "left-right check, tolerance in px", "1",
     [](Text text, MatchParams& p) {
       return set_limit(text, 0, kMaxDisparities, p.left_right_tolerance);
     }},
    {"uniqueness", "1..99 or off", "percent that a rival must cost more", "15",
     [](Text text, MatchParams& p) { return set_limit(text, 1, 99, p.uniqueness_percent); }},
    {"distinct", "on or off", "drop matches that hardly differ from their rivals", "on",
     [](Text text, MatchParams& p) { return set_switch(text, p.distinct); }},
    {"texture", "1..127 or off", "drop pixels with less mean |derivative| about them", "4",
     [](Text text, MatchParams& p) { return set_limit(text, 1, 127, p.min_texture); }},
    {"histogram", "1..1000 or off", "drop disparities rarer than so many thousandths", "3",
     [](Text text, MatchParams& p) { return set_limit(text, 1, 1000, p.histogram_permille); }},
    {"speckle", "1..16777216 or off", "drop connected patches of fewer px", "100",
     [](Text text, MatchParams& p) { return set_limit(text, 1, 1 << 24, p.speckle_pixels); }},
    {"subpixel", "equiangular, parabola, least-squares or off", "fit to 1/16 px", "equiangular",
     [](Text text, MatchParams& p) { return set_named(text, kFits, p.subpixel); }},
    {"median", "on or off", "3x3 median of the disparities", "on",
     [](Text text, MatchParams& p) { return set_switch(text, p.median); }},
    {"fill", "on or off", "give pixels without a disparity that of their background", "on",
     [](Text text, MatchParams& p) { return set_switch(text, p.fill); }},
}};

}  // namespace

std::span<const MatchOption> match_options() noexcept { return kOptions; }

const MatchOption* find_match_option(std::string_view name) noexcept {
  const auto* const found = std::ranges::find(kOptions, name, &MatchOption::name);
  return found == kOptions.end() ? nullptr : found;
}

}  // namespace stof::dsp
