#include "lab/search/energy.h"

#include <algorithm>

#include "dsp/stereo/cost/aggregated_ad_census.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/cost_layout.h"

namespace stof::lab {
namespace {

bool is(const MatchParams& params, Method method) noexcept { return params.method == method; }

constexpr std::int64_t kLargestScaledCost = 8191;

// AD-Census is a mean, the others are sums over a block.
std::int64_t area_of(const MatchParams& params) noexcept {
  return params.cost == Cost::kAdCensus ? 1
                                        : std::int64_t{params.block_width} * params.block_height;
}

Smoothness smoothness_of(const MatchParams& params) noexcept {
  return params.smoothness.value_or(default_smoothness(params.cost));
}

int occlusion_of(const MatchParams& params) noexcept {
  return params.occlusion.value_or(default_occlusion(params.cost));
}

// A change of grey values by so many levels may be an edge of surfaces.
constexpr int kEdge = 16;

template <typename Sum>
EdgePenalties<Sum> penalties_of(std::int64_t small, std::int64_t large) noexcept {
  return {.small = static_cast<Sum>(small),
          .large = static_cast<Sum>(large),
          .edge = kEdge,
          .strong_edge = 2 * kEdge};
}

// The highest energy, of one step of a search in block sums, that is not rounded down.
std::int64_t largest_energy(const MatchParams& params) noexcept {
  const Smoothness smoothness = smoothness_of(params);
  std::int64_t pixel = largest_difference(params);
  if (is(params, Method::kScanlineOptimisation) || is(params, Method::kDynamicProgramming)) {
    pixel += 2 * std::int64_t{smoothness.large_step};
  }
  if (is(params, Method::kDynamicProgramming)) {
    pixel += std::int64_t{lanes_of(params)} * occlusion_of(params);
  }
  return area_of(params) * pixel;
}

}  // namespace

int largest_difference(const MatchParams& params) noexcept {
  const int values = params.prefilter_cap ? 2 * *params.prefilter_cap : 255;
  switch (params.cost) {
    case Cost::kSad:
      return values;
    case Cost::kSsd:
      return values * values;
    case Cost::kCensus5x5:
      return kCensus5x5.bits();
    case Cost::kCensus9x7:
      return kCensus9x7.bits();
    case Cost::kAdCensus:
      break;
  }
  return kLargestMeanCost;
}

std::int64_t largest_cost(const MatchParams& params) noexcept {
  const std::int64_t sum = area_of(params) * largest_difference(params);
  const bool scaled = is(params, Method::kSemiGlobal) && params.cost != Cost::kAdCensus;
  return scaled ? std::min<std::int64_t>(sum, kLargestScaledCost) : sum;
}

CostScale cost_scale(const MatchParams& params) noexcept {
  return {
      .largest = largest_cost(params),
      .margin_percent = params.cost == Cost::kAdCensus ? kAdCensusMarginPercent : kMarginPercent};
}

bool needs_wide_sums(const MatchParams& params) noexcept {
  return !is(params, Method::kSemiGlobal) && largest_energy(params) >= kNoCost<std::uint16_t>;
}

template <typename Sum>
EdgePenalties<Sum> block_penalties(const MatchParams& params) noexcept {
  const Smoothness smoothness = smoothness_of(params);
  return penalties_of<Sum>(area_of(params) * smoothness.small_step,
                           area_of(params) * smoothness.large_step);
}
template EdgePenalties<std::uint16_t> block_penalties(const MatchParams&) noexcept;
template EdgePenalties<std::uint32_t> block_penalties(const MatchParams&) noexcept;

template <typename Sum>
Sum block_occlusion(const MatchParams& params) noexcept {
  return static_cast<Sum>(area_of(params) * occlusion_of(params));
}
template std::uint16_t block_occlusion(const MatchParams&) noexcept;
template std::uint32_t block_occlusion(const MatchParams&) noexcept;

// Block sums times this, over 65536, plus a large step, stay below 8192: eight paths fit u16.
std::uint32_t path_factor(const MatchParams& params) noexcept {
  const std::int64_t most =
      area_of(params) * (largest_difference(params) + smoothness_of(params).large_step);
  return static_cast<std::uint32_t>(
      std::min<std::int64_t>((kLargestScaledCost << 16) / most, 1 << 16));
}

PathParams<std::uint16_t> block_path_params(const MatchParams& params) noexcept {
  const std::int64_t factor = path_factor(params);
  const Smoothness smoothness = smoothness_of(params);
  const auto scaled = [&](int step) noexcept { return (area_of(params) * step * factor) >> 16; };
  return {.directions = params.directions,
          .lanes = lanes_of(params),
          .guided = params.guided,
          .penalties = penalties_of<std::uint16_t>(scaled(smoothness.small_step),
                                                   scaled(smoothness.large_step))};
}

}  // namespace stof::lab
