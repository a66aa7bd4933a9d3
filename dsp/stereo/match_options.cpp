#include "dsp/stereo/match_options.h"

#include <algorithm>
#include <array>
#include <optional>

#include "dsp/stereo/option_text.h"

namespace stof::dsp {
namespace {

using namespace option_text;  // NOLINT(google-build-using-namespace): what this file is made of

constexpr std::array<Named<Subpixel>, 4> kFits{{{"off", Subpixel::kWhole},
                                                {"equiangular", Subpixel::kEquiangular},
                                                {"parabola", Subpixel::kParabola},
                                                {"least-squares", Subpixel::kLeastSquares}}};

bool set_block(std::string_view text, MatchParams& params) noexcept {
  const std::size_t by = text.find('x');
  if (by == std::string_view::npos) {
    return false;
  }
  const std::optional<int> width = parse_number_in<int>(text.substr(0, by), 1, kMaxBlock);
  const std::optional<int> height = parse_number_in<int>(text.substr(by + 1), 1, kMaxBlock);
  if (!width || !height) {
    return false;
  }
  params.block_width = *width;
  params.block_height = *height;
  return true;
}

// P1,P2.
bool set_penalties(std::string_view text, MatchParams& params) noexcept {
  const std::size_t comma = std::min(text.find(','), text.size());
  const std::optional<int> small = parse_number_in<int>(text.substr(0, comma), 0, kMaxStep);
  const std::optional<int> large = comma < text.size()
                                       ? parse_number_in<int>(text.substr(comma + 1), 0, kMaxStep)
                                       : std::nullopt;
  if (!small || !large || *small > *large) {
    return false;
  }
  params.smoothness = {.small_step = *small, .large_step = *large};
  return true;
}

using Text = std::string_view;

constexpr std::array<MatchOption, 14> kOptions{{
    {"block", "WxH from 1x1 to 64x64", "block in px", "", set_block},
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
    {"penalties", "P1,P2 up to 36,36",
     "preset quality: cost of a change of disparity by one, by more", "", set_penalties},
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
}};

}  // namespace

std::span<const MatchOption> match_options() noexcept { return kOptions; }

const MatchOption* find_match_option(std::string_view name) noexcept {
  const auto* const found = std::ranges::find(kOptions, name, &MatchOption::name);
  return found == kOptions.end() ? nullptr : found;
}

}  // namespace stof::dsp
