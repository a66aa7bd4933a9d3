#include "lab/cost/sum_rows.h"

#include <algorithm>
#include <type_traits>

#include "dsp/base/index.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "lab/block/interest.h"

namespace stof::lab {
namespace {

template <typename From, typename To>
void convert(std::span<const From> from, std::span<To> to) noexcept {
  std::ranges::transform(from, to.begin(), [](From cost) noexcept {
    return cost == kNoCost<From> ? kNoCost<To> : static_cast<To>(cost);
  });
}

}  // namespace

template <typename Sum>
SumRows<Sum>::SumRows(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params) {
  const std::size_t row = index(width) * index(lanes_of(params));
  costs_ = arena.take<Sum>(row);
  if (params.cost == Cost::kAdCensus) {
    ad_census_.emplace(params, width, arena);
    narrow_ = arena.take<std::uint8_t>(row);
  } else {
    blocks_.emplace(params, width, arena);
  }
  if (params.interest) {
    interesting_left_ = arena.take<std::uint8_t>(index(width));
    interesting_right_ = arena.take<std::uint8_t>(index(width));
  }
}

template <typename Sum>
void SumRows<Sum>::start(const PreparedPair& pair) noexcept {
  pair_ = &pair;
  if (ad_census_) {
    ad_census_->start(pair.left_grey(), pair.right_grey());
  } else {
    blocks_->start({.left = pair.left(), .right = pair.right()});
  }
}

template <typename Sum>
std::span<const Sum> SumRows<Sum>::row(int y) noexcept {
  const std::size_t n = index(pair_->left().width()) * index(lanes_of(params_));
  const std::span<Sum> costs = costs_.first(n);
  if (ad_census_) {
    ad_census_->row(y, narrow_.first(n));
    convert(std::span<const std::uint8_t>(narrow_.first(n)), costs);
  } else if (std::is_same_v<Sum, std::uint32_t> && !CostRows::wide(params_)) {
    convert(blocks_->row<std::uint16_t>(y), costs);
  } else if (params_.interest) {
    std::ranges::copy(blocks_->row<Sum>(y), costs.begin());
  } else {
    return blocks_->row<Sum>(y);
  }
  if (params_.interest) {
    keep_interesting_pairs(y, costs);
  }
  return costs;
}

template <typename Sum>
void SumRows<Sum>::keep_interesting_pairs(int y, std::span<Sum> costs) noexcept {
  const int cap = *params_.prefilter_cap;
  const std::span<std::uint8_t> left = interesting_left_.first(index(pair_->left().width()));
  const std::span<std::uint8_t> right = interesting_right_.first(left.size());
  if (*params_.interest == Interest::kMaxima) {
    interest_maxima(pair_->left().row(y), cap, (cap + 1) / 2, left);
    interest_maxima(pair_->right().row(y), cap, (cap + 1) / 2, right);
  } else {
    interest_above(pair_->left().row(y), cap, (2 * cap + 2) / 3, left);
    interest_above(pair_->right().row(y), cap, (cap + 2) / 3, right);
  }
  keep_interesting(left, right, params_.min_disparity, lanes_of(params_), costs);
}

template class SumRows<std::uint16_t>;
template class SumRows<std::uint32_t>;

}  // namespace stof::lab
