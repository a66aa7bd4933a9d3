#include "dsp/stereo/row_search.h"

#include <algorithm>
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

bool judges_by_wide_sums(const MatchParams& params) noexcept {
  return params.uniqueness_percent || params.subpixel == Subpixel::kEquiangular ||
         params.subpixel == Subpixel::kParabola;
}

}  // namespace

template <typename Sum>
void RowSearch<Sum>::start(const PreparedPair& pair, Guide guide) noexcept {
  STOF_CHECK(guide.empty() || (params_.guided && same_size(guide, pair.left())));
  pair_ = &pair;
  guide_ = guide;
  if (cross_rows_) {
    cross_rows_->start(pair.left_grey(), pair.right_grey());
  } else if (block_search_) {
    block_search_->start({.left = pair.left(), .right = pair.right()});
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
  FoundRow<Sum> found = search(y);
  const GuideRow guide = guide_.empty() ? GuideRow{} : GuideRow{guide_.row(y)};
  keep_guided(guide, found.winners);
  settle_single_candidates(params_.min_disparity, params_.disparities, found.winners);
  keep_guided(guide, found.winners);
  if (!found.fitted.empty()) {
    settle_fits(found.winners);
  }
  return found;
}

// What had one candidate has no neighbours to be fitted to.
template <typename Sum>
void RowSearch<Sum>::settle_fits(std::span<const std::int16_t> winners) noexcept {
  const int width = static_cast<int>(winners.size());
  for (const int x :
       {params_.min_disparity, width + params_.min_disparity + params_.disparities - 2}) {
    if (x >= 0 && x < width && winners[size(x)] != kNoWinner) {
      fitted_[size(x)] = Disparity::from_pixels(params_.min_disparity + winners[size(x)]);
    }
  }
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
    if (block_search_) {
      search_blocks(y, found);
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

template <typename Sum>
void RowSearch<Sum>::search_blocks(int y, FoundRow<std::uint16_t>& found) noexcept {
  if constexpr (std::is_same_v<Sum, std::uint16_t>) {
    const std::size_t n = found.winners.size();
    const std::span<Sum> costs = costs_.empty() ? costs_ : costs_.first(n * size(lanes_));
    const std::span<Disparity> fitted = fitted_.first(n);
    block_search_->row(y, {.winners = found.winners, .fitted = fitted, .costs = costs});
    found.costs = costs;
    found.judged = guided_costs(y, costs);
    if (found.judged.data() == costs.data()) {
      found.fitted = fitted;
    } else {
      best::winners(found.judged, lanes_, found.winners);
    }
  }
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
