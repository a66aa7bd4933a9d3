#include "dsp/stereo/search/semi_global_search.h"

#include <algorithm>

#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/border_columns.h"

namespace stof::dsp {
namespace {

constexpr int kEdge = 6;

// What SemiGlobal asks of u8 costs.
constexpr int kLargestStep = (255 - 1 - kLargestMeanCost) / 2;
static_assert(kMaxStep <= kLargestStep);
static_assert(SemiGlobalSearch::kDirections * (kLargestMeanCost + kMaxStep) <
              kNoCost<std::uint8_t>);

}  // namespace

PathParams<std::uint8_t> ad_census_path_params(const MatchParams& params, int directions) noexcept {
  const Smoothness smoothness = params.smoothness.value_or(kDefaultSmoothness);
  const auto step = [](int cost) noexcept {
    return static_cast<std::uint8_t>(std::min(cost, kLargestStep));
  };
  return {.directions = directions,
          .lanes = lanes_of(params),
          .guided = params.guided,
          .penalties = {.small = step(smoothness.small_step),
                        .large = step(smoothness.large_step),
                        .edge = kEdge,
                        .strong_edge = 2 * kEdge}};
}

SemiGlobalSearch::SemiGlobalSearch(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params),
      costs_(params, width, arena),
      paths_(ad_census_path_params(params, kDirections), width, arena),
      checks_(params, kAdCensusScale, width, arena),
      winners_(arena.take_passing<std::int16_t>(index(width))) {}

void SemiGlobalSearch::start(const PreparedPair& pair, Guide guide) noexcept {
  pair_ = &pair;
  guide_ = guide;
  costs_.start(pair.left_grey(), pair.right_grey());
  paths_.start(pair.left_grey(), costs_, guide);
}

void SemiGlobalSearch::match(int y, const MatchedRow& out) noexcept {
  const std::span<const std::uint8_t> sums = paths_.sums(y);
  const std::span<std::int16_t> winners = winners_.first(out.disparity.size());
  best::winners(sums, lanes_of(params_), winners);
  finish_winners(params_, row_of(guide_, y), winners);
  checks_.apply(
      FoundRow<std::uint8_t>{.costs = paths_.costs(y), .judged = sums, .winners = winners}, *pair_,
      y, out);
}

}  // namespace stof::dsp
