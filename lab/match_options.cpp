#include "lab/match_options.h"

#include <algorithm>
#include <array>
#include <optional>

#include "dsp/base/check.h"
#include "dsp/stereo/match_options.h"
#include "dsp/stereo/option_text.h"

namespace stof::lab {
namespace {

using namespace dsp::option_text;  // NOLINT(google-build-using-namespace): what this is made of

constexpr std::array<Named<Method>, 4> kMethods{{{"wta", Method::kWinnerTakesAll},
                                                 {"dp", Method::kDynamicProgramming},
                                                 {"so", Method::kScanlineOptimisation},
                                                 {"sgm", Method::kSemiGlobal}}};
constexpr std::array<Named<Cost>, 6> kCosts{{{"sad", Cost::kSad},
                                             {"ssd", Cost::kSsd},
                                             {"census5x5", Cost::kCensus5x5},
                                             {"census5", Cost::kCensus5x5},
                                             {"census9x7", Cost::kCensus9x7},
                                             {"mixed", Cost::kAdCensus}}};  // AD-Census, aggregated
constexpr std::array<Named<BlockShape>, 3> kShapes{{{"fixed", BlockShape::kFixed},
                                                    {"cross", BlockShape::kCross},
                                                    {"region", BlockShape::kRegion}}};
constexpr std::array<Named<std::optional<Interest>>, 3> kInterests{
    {{"off", std::nullopt},
     {"maxima", Interest::kMaxima},
     {"thresholds", Interest::kTwoThresholds}}};

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
  params.smoothness = {.small_step = values[0], .large_step = values[1]};
  params.occlusion = count == 3 ? values[2] : values[1] / 2;
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

// One of the appliance's.
MatchOption common(std::string_view name) noexcept {
  const dsp::MatchOption* const option = dsp::find_match_option(name);
  STOF_CHECK(option != nullptr);
  return {.name = option->name,
          .values = option->values,
          .meaning = option->meaning,
          .alone = option->alone,
          .common = option};
}

using Text = std::string_view;

const auto& all_options() noexcept {
  static const std::array<MatchOption, 22> options{{
      {"method", "wta, dp, so or sgm",
       "search: winner takes all, dynamic programming, scanline optimisation, semi-global", "",
       [](Text text, MatchParams& p) { return set_named(text, kMethods, p.method); }},
      {"cost", "sad, ssd, census5x5, census9x7 or mixed",
       "what two pixels differ by; mixed: AD-Census", "",
       [](Text text, MatchParams& p) { return set_named(text, kCosts, p.cost); }},
      common("block"),
      {"shape", "fixed, cross or region", "blocks that grow until they meet an edge, up to --block",
       "", [](Text text, MatchParams& p) { return set_named(text, kShapes, p.block_shape); }},
      common("min-disparity"),
      common("prefilter"),
      common("smooth"),
      common("equalise"),
      {"penalties", "P1,P2 or P1,P2,OCCLUSION",
       "cost of a change of disparity by one, by more, in units of one pixel's cost", "",
       set_penalties},
      {"directions", "2, 4, 5 or 8", "paths of the semi-global search", "", set_directions},
      {"band", "0..256 or off",
       "scanline optimisation: px around what winner takes all found nearby", "",
       [](Text text, MatchParams& p) { return set_limit(text, 0, kMaxDisparities, p.band); }},
      {"pyramid", "1, 2 or off", "coarse to fine, from half or a quarter of the size", "2",
       [](Text text, MatchParams& p) { return set_limit(text, 1, 2, p.pyramid_levels); }},
      {"interest", "maxima, thresholds or off", "match only where the derivative stands out",
       "maxima", [](Text text, MatchParams& p) { return set_named(text, kInterests, p.interest); }},
      common("lr"),
      common("uniqueness"),
      common("distinct"),
      common("texture"),
      common("histogram"),
      common("speckle"),
      common("subpixel"),
      common("median"),
      {"fill", "on or off", "give pixels without a disparity that of their background", "on",
       [](Text text, MatchParams& p) { return set_switch(text, p.fill); }},
  }};
  return options;
}

}  // namespace

bool MatchOption::set(std::string_view value, MatchParams& params) const noexcept {
  return common != nullptr ? common->set(value, params) : own(value, params);
}

std::span<const MatchOption> match_options() noexcept { return all_options(); }

const MatchOption* find_match_option(std::string_view name) noexcept {
  const auto* const found = std::ranges::find(all_options(), name, &MatchOption::name);
  return found == all_options().end() ? nullptr : found;
}

}  // namespace stof::lab
