#include "lab/match_params.h"

#include "dsp/stereo/search/semi_global_search.h"

namespace stof::lab {
namespace {

bool in_range(const std::optional<int>& value, int low, int high) noexcept {
  return !value || (*value >= low && *value <= high);
}

bool all_in_ranges(const MatchParams& params) noexcept {
  const dsp::Smoothness smoothness = params.smoothness.value_or(dsp::Smoothness{});
  return in_ranges(params) && smoothness.small_step >= 0 &&
         smoothness.large_step >= smoothness.small_step && smoothness.large_step <= kMaxPenalty &&
         in_range(params.occlusion, 0, kMaxPenalty) &&
         dsp::SemiGlobalSearch::Paths::valid(params.directions) &&
         in_range(params.band, 0, dsp::kMaxDisparities) && in_range(params.pyramid_levels, 1, 2);
}

}  // namespace

const char* problem(const MatchParams& params) noexcept {
  const bool whole_search = params.block_shape != BlockShape::kFixed || params.pyramid_levels;
  const bool by_costs = cost_fit(params.subpixel) != dsp::CostFit::kNone;
  const bool other_search = params.cost != Cost::kSad || params.method != Method::kWinnerTakesAll;
  if (!all_in_ranges(params)) {
    return "a value is out of its range: see the help text";
  }
  if ((params.interest || params.min_texture) && !params.prefilter_cap) {
    return "interest operator and texture mask look at the derivative: give a prefilter";
  }
  if (params.interest && params.method != Method::kWinnerTakesAll) {
    return "only winner takes all is for interesting positions: choose method wta";
  }
  if (params.band && params.method != Method::kScanlineOptimisation) {
    return "a band is part of scanline optimisation: choose method so";
  }
  if (params.distinct && (params.interest || params.band)) {
    return "distinctness compares with all candidates, a band and interesting positions leave few: "
           "choose one of the two";
  }
  if (whole_search && (other_search || params.interest)) {
    return "adaptive blocks and coarse to fine are for method wta with cost sad: choose these";
  }
  if (whole_search && (by_costs || params.distinct || params.uniqueness_percent)) {
    return "adaptive blocks and coarse to fine keep no costs for uniqueness, distinctness and fits "
           "of costs: leave these out, or fit by least-squares";
  }
  if (whole_search && params.guided) {
    return "adaptive blocks and coarse to fine keep no costs that a guide could narrow: leave one "
           "of the two out";
  }
  if (params.block_shape != BlockShape::kFixed && params.pyramid_levels) {
    return "coarse to fine is for fixed blocks: choose one of the two";
  }
  return "";
}

Status check(const MatchParams& params, int width, int height) noexcept {
  if (width < 1 || height < 1 || *problem(params) != '\0') {
    return Status::kInvalidArgument;
  }
  return fits(params, width, height) ? Status::kOk : Status::kTooLarge;
}

dsp::Smoothness default_smoothness(Cost cost) noexcept {
  switch (cost) {
    case Cost::kSad:
      return {.small_step = 12, .large_step = 40};
    case Cost::kSsd:
      return {.small_step = 200, .large_step = 800};
    case Cost::kCensus5x5:
      return {.small_step = 6, .large_step = 24};
    case Cost::kCensus9x7:
      return {.small_step = 16, .large_step = 80};
    case Cost::kAdCensus:
      break;
  }
  return dsp::kDefaultSmoothness;
}

int default_occlusion(Cost cost) noexcept {
  switch (cost) {
    case Cost::kSad:
      return 12;
    case Cost::kSsd:
      return 200;
    case Cost::kCensus5x5:
      return 9;
    case Cost::kCensus9x7:
      return 25;
    case Cost::kAdCensus:
      break;
  }
  return 16;
}

MatchParams method_defaults(Method method) noexcept {
  MatchParams params;
  if (method != Method::kWinnerTakesAll) {
    params.method = method;
    params.block_width = 5;
    params.block_height = 5;
  }
  return params;
}

MatchParams as_the_appliance(const dsp::MatchParams& params) noexcept {
  MatchParams same;
  static_cast<dsp::MatchParams&>(same) = params;
  if (params.search == dsp::Search::kSemiGlobal) {
    same.cost = Cost::kAdCensus;
    same.method = Method::kSemiGlobal;
  }
  return same;
}

bool sums_paths(const MatchParams& params) noexcept {
  return params.method == Method::kSemiGlobal || params.method == Method::kScanlineOptimisation;
}

std::optional<dsp::MatchParams> appliance_params(const MatchParams& params) noexcept {
  dsp::MatchParams same = static_cast<const dsp::MatchParams&>(params);
  if (params.cost == Cost::kAdCensus && params.method == Method::kSemiGlobal &&
      params.directions == dsp::SemiGlobalSearch::kDirections) {
    same.search = dsp::Search::kSemiGlobal;
  } else if (params.cost == Cost::kSad && params.method == Method::kWinnerTakesAll &&
             params.block_shape == BlockShape::kFixed && !params.interest &&
             !params.pyramid_levels) {
    same.search = dsp::Search::kBlocks;
    same.smoothness.reset();  // of no use to it
  } else {
    return std::nullopt;
  }
  return *dsp::problem(same) == '\0' ? std::optional(same) : std::nullopt;
}

}  // namespace stof::lab
