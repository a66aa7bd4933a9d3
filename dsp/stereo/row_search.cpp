#include "dsp/stereo/row_search.h"

#include <algorithm>
#include <limits>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/block/interest.h"
#include "dsp/stereo/search/energy.h"
#include "dsp/stereo/search/ordered.h"
#include "dsp/stereo/search/scanline.h"
#include "dsp/stereo/search/single_candidate.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

bool is_method(const MatchParams& params, Method method) noexcept {
  return params.method == method;
}

template <typename From, typename To>
void convert(std::span<const From> from, std::span<To> to) noexcept {
  std::ranges::transform(from, to.begin(), [](From cost) noexcept {
    return cost == kNoCost<From> ? kNoCost<To> : static_cast<To>(cost);
  });
}

using NarrowPaths = SemiGlobal<std::uint8_t, std::uint8_t>;
using MixedPaths = SemiGlobal<std::uint8_t, std::uint16_t>;
using BlockPaths = SemiGlobal<std::uint16_t, std::uint16_t>;

std::size_t path_bytes(const MatchParams& params, int width) noexcept {
  if (params.cost != Cost::kMixed) {
    return BlockPaths::bytes_needed(block_path_params(params), width);
  }
  const PathParams<std::uint8_t> how = mixed_path_params(params);
  return fit_narrow_sums(how) ? NarrowPaths::bytes_needed(how, width)
                              : MixedPaths::bytes_needed(how, width);
}

bool judges_by_wide_sums(const MatchParams& params) noexcept {
  return params.uniqueness_percent || params.subpixel == Subpixel::kEquiangular ||
         params.subpixel == Subpixel::kParabola;
}

}  // namespace

template <typename Sum>
std::size_t RowSearch<Sum>::bytes_needed(const MatchParams& params, int width) noexcept {
  const std::size_t lanes = size(lanes_of(params));
  const std::size_t row = Arena::bytes_for<Sum>(size(width) * lanes);
  std::size_t bytes = row + Arena::bytes_for<Sum>(size(width) + 1) +
                      4 * Arena::bytes_for<std::uint8_t>(size(width)) +
                      Arena::bytes_for<std::int16_t>(size(width));
  if (params.cost == Cost::kMixed) {
    bytes += CrossCosts::bytes_needed(params, width) +
             Arena::bytes_for<std::uint8_t>(size(width) * lanes);
  } else {
    bytes += CostRows::bytes_needed(params, width);
  }
  if (is_method(params, Method::kScanline)) {
    bytes += 2 * row;
  }
  if (is_method(params, Method::kOrdered)) {
    bytes += Arena::bytes_for<std::byte>(ordered_bytes_needed<Sum>(width, lanes_of(params)));
  }
  if (is_method(params, Method::kSemiGlobal)) {
    bytes += path_bytes(params, width);
  } else {
    bytes += params.guided ? row : 0;
  }
  return bytes;
}

template <typename Sum>
RowSearch<Sum>::RowSearch(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params), lanes_(lanes_of(params)) {
  const std::size_t row = size(width) * size(lanes_);
  if (!is_method(params, Method::kSemiGlobal)) {
    penalties_ = block_penalties<Sum>(params);
    occlusion_ = block_occlusion<Sum>(params);
  }
  costs_ = arena.take<Sum>(row);
  large_ = arena.take<Sum>(size(width) + 1);
  continued_ = arena.take<std::uint8_t>(size(width));
  interesting_left_ = arena.take<std::uint8_t>(size(width));
  interesting_right_ = arena.take<std::uint8_t>(size(width));
  winners_ = arena.take<std::int16_t>(size(width));
  if (params.cost == Cost::kMixed) {
    cross_rows_.emplace(params, width, arena);
    narrow_ = arena.take<std::uint8_t>(row);
  } else {
    block_rows_.emplace(params, width, arena);
  }
  if (is_method(params, Method::kScanline)) {
    paths_ = arena.take<Sum>(row);
    marginals_ = arena.take<Sum>(row);
  }
  if (is_method(params, Method::kOrdered)) {
    ordered_scratch_ = arena.take<std::byte>(ordered_bytes_needed<Sum>(width, lanes_));
  }
  if (is_method(params, Method::kSemiGlobal)) {
    const PathParams<std::uint8_t> mixed = mixed_path_params(params);
    if (params.cost != Cost::kMixed) {
      block_paths_.emplace(block_path_params(params), width, arena);
    } else if (fit_narrow_sums(mixed)) {
      narrow_paths_.emplace(mixed, width, arena);
    } else {
      mixed_paths_.emplace(mixed, width, arena);
    }
  } else if (params.guided) {
    masked_ = arena.take<Sum>(row);
  }
}

template <typename Sum>
void RowSearch<Sum>::start(const PreparedPair& pair, Guide guide) noexcept {
  STOF_CHECK(guide.empty() || (params_.guided && same_size(guide, pair.left())));
  pair_ = &pair;
  guide_ = guide;
  if (cross_rows_) {
    cross_rows_->start(pair.left_grey(), pair.right_grey());
  } else {
    block_rows_->start({.left = pair.left(), .right = pair.right()});
  }
  if (narrow_paths_) {
    narrow_paths_->start(pair.left_grey(), *cross_rows_, guide);
  }
  if (mixed_paths_) {
    mixed_paths_->start(pair.left_grey(), *cross_rows_, guide);
  }
  if (block_paths_) {
    scaled_.start(*block_rows_, params_);
    block_paths_->start(pair.left_grey(), scaled_, guide);
  }
}

template <typename Sum>
FoundRow<Sum> RowSearch<Sum>::row(int y) noexcept {
  const FoundRow<Sum> found = search(y);
  const GuideRow guide = guide_.empty() ? GuideRow{} : GuideRow{guide_.row(y)};
  keep_guided(guide, found.winners);
  settle_single_candidates(params_.min_disparity, params_.disparities, found.winners);
  keep_guided(guide, found.winners);
  return found;
}

template <typename Sum>
FoundRow<Sum> RowSearch<Sum>::search(int y) noexcept {
  const std::size_t n = size(pair_->left().width());
  const std::span<std::int16_t> winners = winners_.first(n);
  const std::span<std::uint8_t> continued = continued_.first(n);
  std::ranges::fill(continued, std::uint8_t{0});
  FoundRow<Sum> found{.winners = winners, .continued = continued};
  if constexpr (std::is_same_v<Sum, std::uint16_t>) {
    if (is_method(params_, Method::kSemiGlobal)) {
      if (narrow_paths_) {
        narrow_semi_global(y, found);
      } else {
        semi_global(y, found);
      }
      return found;
    }
  }
  found.costs = block_costs(y);
  found.judged = guided_costs(y, found.costs);
  switch (params_.method) {
    case Method::kScanline:
      scanline(y, found);
      break;
    case Method::kOrdered:
      ordered(y, found);
      break;
    default:
      if (params_.interest) {
        interesting_winners(found.judged, lanes_, winners);
      } else {
        best::winners(found.judged, lanes_, winners);
      }
  }
  return found;
}

// Rows as they come, or in costs_ where they have to be changed.
template <typename Sum>
std::span<const Sum> RowSearch<Sum>::block_costs(int y) noexcept {
  const std::size_t n = size(pair_->left().width()) * size(lanes_);
  const std::span<Sum> costs = costs_.first(n);
  if (cross_rows_) {
    cross_rows_->row(y, narrow_.first(n));
    convert(std::span<const std::uint8_t>(narrow_.first(n)), costs);
  } else if (std::is_same_v<Sum, std::uint32_t> && !CostRows::wide(params_)) {
    convert(block_rows_->row<std::uint16_t>(y), costs);
  } else if (params_.interest || params_.band) {
    std::ranges::copy(block_rows_->row<Sum>(y), costs.begin());
  } else {
    return block_rows_->row<Sum>(y);
  }
  if (params_.interest) {
    keep_interesting_pairs(y, costs);
  }
  return costs;
}

template <typename Sum>
std::span<const Sum> RowSearch<Sum>::guided_costs(int y, std::span<const Sum> costs) noexcept {
  // A band is cut out of what is searched.
  if (guide_.empty() || (!narrows(guide_.row(y), lanes_) && !params_.band)) {
    return costs;
  }
  const std::span<Sum> masked = masked_.first(costs.size());
  best::mask_costs(costs, guide_.row(y), lanes_, masked);
  return masked;
}

template <typename Sum>
void RowSearch<Sum>::semi_global(int y, FoundRow<std::uint16_t>& found) noexcept {
  const std::span<std::uint16_t> sums =
      mixed_paths_ ? mixed_paths_->sums(y) : block_paths_->sums(y);
  mark_outside(params_, pair_->left().width(), sums);
  if (!guide_.empty()) {
    best::mask_costs(std::span<const std::uint16_t>(sums), guide_.row(y), lanes_, sums);
  }
  found.judged = sums;
  best::winners(found.judged, lanes_, found.winners);
  if (mixed_paths_) {
    found.mixed_costs = mixed_paths_->costs(y);
  } else {
    found.costs = block_paths_->costs(y);
  }
}

template <typename Sum>
void RowSearch<Sum>::narrow_semi_global(int y, FoundRow<std::uint16_t>& found) noexcept {
  const std::span<std::uint8_t> sums =
      narrow_paths_->sums(y);  // saturated: what is outside stays so
  found.narrow_judged = sums;
  found.mixed_costs = narrow_paths_->costs(y);
  best::winners(found.narrow_judged, lanes_, found.winners);
  if constexpr (std::is_same_v<Sum, std::uint16_t>) {
    if (judges_by_wide_sums(params_)) {
      const std::span<std::uint16_t> wide = costs_.first(sums.size());
      convert(found.narrow_judged, wide);
      found.judged = wide;
    }
  }
}

template <typename Sum>
void RowSearch<Sum>::scanline(int y, FoundRow<Sum>& found) noexcept {
  const std::span<const Sum> costs = found.judged;
  const std::span<Sum> paths = paths_.first(costs.size());
  const std::span<Sum> large = large_.first(found.winners.size() + 1);
  if (params_.band) {
    best::winners(costs, lanes_, found.winners);
    keep_band(std::span<const std::int16_t>(found.winners), lanes_, *params_.band,
              (guide_.empty() ? costs_ : masked_).first(costs.size()));
  }
  edge_penalties_along(pair_->left_grey().row(y), penalties_, large);
  scanline_winners(costs, lanes_, penalties_.small, std::span<const Sum>(large), paths,
                   found.winners);
  const std::span<Sum> marginals = marginals_.first(costs.size());
  scanline_marginals(costs, lanes_, penalties_.small, std::span<const Sum>(large),
                     std::span<const Sum>(paths), marginals);
  found.judged = marginals;
}

template <typename Sum>
void RowSearch<Sum>::ordered(int y, FoundRow<Sum>& found) noexcept {
  const std::span<Sum> large = large_.first(found.winners.size() + 1);
  edge_penalties_along(pair_->left_grey().row(y), penalties_, large);
  ordered_winners(found.judged, lanes_,
                  {.small = penalties_.small, .occlusion = occlusion_, .large = large},
                  Arena(ordered_scratch_), found.winners);
  extend_background(found.winners, continued_.first(found.winners.size()));
}

template <typename Sum>
void RowSearch<Sum>::keep_interesting_pairs(int y, std::span<Sum> costs) noexcept {
  const int cap = *params_.prefilter_cap;
  const std::span<std::uint8_t> left = interesting_left_.first(size(pair_->left().width()));
  const std::span<std::uint8_t> right = interesting_right_.first(left.size());
  if (*params_.interest == Interest::kMaxima) {
    interest_maxima(pair_->left().row(y), cap, (cap + 1) / 2, left);
    interest_maxima(pair_->right().row(y), cap, (cap + 1) / 2, right);
  } else {
    interest_above(pair_->left().row(y), cap, (2 * cap + 2) / 3, left);
    interest_above(pair_->right().row(y), cap, (cap + 2) / 3, right);
  }
  keep_interesting(left, right, params_.min_disparity, lanes_, costs);
}

template class RowSearch<std::uint16_t>;
template class RowSearch<std::uint32_t>;

}  // namespace stof::dsp
