#pragma once

#include <algorithm>
#include <utility>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/search/path_costs.h"
#include "dsp/stereo/search/semi_global.h"
#include "dsp/stereo/search/sum_path_costs.h"

// The members of SemiGlobal, for whoever instantiates it.
namespace stof::dsp {

template <typename Cost, typename Sum>
SemiGlobal<Cost, Sum>::Fronts SemiGlobal<Cost, Sum>::take_fronts(int shifts, std::size_t row,
                                                                 Arena& arena) noexcept {
  Fronts fronts;
  for (int k = 0; k < shifts; ++k) {
    fronts[index(k)].paths = arena.take_passing<Cost>(row);
    if (k > 0) {
      fronts[index(k)].next = arena.take_passing<Cost>(row);
    }
  }
  return fronts;
}

template <typename Cost, typename Sum>
SemiGlobal<Cost, Sum>::SemiGlobal(const PathParams<Cost>& params, int width, Arena& arena) noexcept
    : params_(params), down_(shifts_down(params.directions)), up_(shifts_up(params.directions)) {
  STOF_CHECK(valid(params.directions) && params.lanes % kCostLanes == 0);
  const std::size_t row = index(width) * index(params.lanes);
  costs_ = arena.take_passing<Cost>(row * index(kKept));
  upwards_ = arena.take_passing<Cost>(row * index(up_) * kStripe);
  downward_ = take_fronts(std::max(down_, up_), row, arena);
  ahead_ = take_fronts(std::max(down_, up_), row, arena);
  if (!in_place()) {
    row_.from_left = arena.take_passing<Cost>(row);
    row_.from_right = arena.take_passing<Cost>(row);
    row_.sums = arena.take_passing<Sum>(row);
  }
  row_.large = arena.take_passing<Cost>(index(width) + 1);
  row_.across = arena.take_passing<Cost>(index(width));
  row_.masked = arena.take_passing<Cost>(params.guided ? row : 0);
}

template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::start(ImageView<const std::uint8_t> grey, CostSource<Cost>& costs,
                                  Guide guide) noexcept {
  STOF_CHECK(guide.empty() || (params_.guided && same_size(guide, grey)));
  grey_ = grey;
  source_ = &costs;
  guide_ = guide;
  STOF_CHECK(index(row_size()) * index(kKept) <= costs_.size());
  kept_ = {};
  stripe_ = -1;
}

template <typename Cost, typename Sum>
std::span<Sum> SemiGlobal<Cost, Sum>::sums(int y) noexcept {
  STOF_CHECK(y >= 0 && y < grey_.height());
  if (y / kStripe != stripe_ || y <= done_) {
    open_stripe(y / kStripe);
  }
  while (done_ + 1 < y) {
    go_down(done_ + 1);
  }
  return sum_row(y);
}

template <typename Cost, typename Sum>
std::span<Cost> SemiGlobal<Cost, Sum>::kept(int y) const noexcept {
  return costs_.subspan(index(y % kKept) * index(row_size()), index(row_size()));
}

template <typename Cost, typename Sum>
std::span<Cost> SemiGlobal<Cost, Sum>::stored(int shift, int y) const noexcept {
  return upwards_.subspan(index(shift * kStripe + y % kStripe) * index(row_size()),
                          index(row_size()));
}

// Valid until the next call.
template <typename Cost, typename Sum>
std::span<const Cost> SemiGlobal<Cost, Sum>::path_costs(int y) noexcept {
  if (guide_.empty() || !narrows(guide_.row(y), params_.lanes)) {
    return kept(y);
  }
  const std::span<Cost> masked = row_.masked.first(index(row_size()));
  best::mask_candidates(std::span<const Cost>(kept(y)), guide_.row(y), params_.lanes, masked);
  return masked;
}

// Rows that are there already stay.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::keep_costs(Rows rows) noexcept {
  if (rows.begin < kept_.begin || rows.begin > kept_.end) {
    kept_ = {rows.begin, rows.begin};
  }
  for (; kept_.end < rows.end; ++kept_.end) {
    source_->row(kept_.end, kept(kept_.end));
  }
  kept_.begin = std::max(kept_.begin, kept_.end - kKept);
}

// The costs of the stripe and of the rows below, all upward paths of its rows, and the downward
// paths of the row above.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::open_stripe(int stripe) noexcept {
  const int begin = stripe * kStripe;
  const int end = std::min(begin + kStripe, grey_.height());
  const int last = (up_ == 0 ? end : std::min(end + kApproach, grey_.height())) - 1;
  if (down_ > 0 && begin > 0) {
    if (stripe == stripe_ + 1 && stripe_ >= 0 && done_ == begin - 1) {
      std::swap(downward_, ahead_);
    } else {
      for (int y = begin - kApproach; y < begin; ++y) {
        keep_costs({y, y + 1});
        advance(y, y > begin - kApproach ? y - 1 : -1, down_, downward_);
      }
    }
  }
  stripe_ = stripe;
  done_ = begin - 1;
  keep_costs({begin, last + 1});
  climb({begin, last + 1});
}

// Upward paths of rows, of which those of the stripe are stored.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::climb(Rows rows) noexcept {
  const int end = std::min(rows.begin + kStripe, rows.end);
  for (int y = rows.end - 1; up_ > 0 && y >= rows.begin; --y) {
    const int from = y + 1 < rows.end ? y + 1 : -1;
    if constexpr (kInPlace) {
      if (in_place() && y < end) {
        sum_axes(y, from, false, ahead_[0], {}, stored(0, y));
        continue;
      }
    }
    advance(y, from, up_, ahead_);
    for (int k = 0; y < end && k < up_; ++k) {
      std::ranges::copy(ahead_[index(k)].paths.first(index(row_size())), stored(k, y).begin());
    }
  }
}

// Downward paths of row y, where no sums of it are wanted or before they are.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::go_down(int y) noexcept {
  advance(y, y - 1, down_, downward_);
  go_ahead(y);
  done_ = y;
}

// The last rows of a stripe are those in which the downward paths of the next one begin.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::go_ahead(int y) noexcept {
  const int first = (stripe_ + 1) * kStripe - kApproach;
  if (y >= first && first + kApproach < grey_.height()) {
    advance(y, y > first ? y - 1 : -1, down_, ahead_);
  }
}

// Paths of row y that come from row `from`, whose own are in fronts; from -1 when y is the first.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::advance(int y, int from, int shifts, Fronts& fronts) noexcept {
  const std::span<const Cost> costs = path_costs(y);
  const std::size_t n = index(row_size());
  for (int k = 0; k < shifts; ++k) {
    Front& front = fronts[index(k)];
    if (from < 0) {
      std::ranges::copy(costs, front.paths.begin());
      continue;
    }
    const std::span<Cost> next = front.next.empty() ? front.paths : front.next;
    best::paths_across(costs, front.paths.first(n), kShifts[index(k)], params_.lanes,
                       params_.penalties.small, across(y, from, kShifts[index(k)]), next.first(n));
    if (!front.next.empty()) {
      std::swap(front.paths, front.next);
    }
  }
}

// Penalties for a large change between two rows; empty where from is -1. Valid until the next call.
template <typename Cost, typename Sum>
std::span<const Cost> SemiGlobal<Cost, Sum>::across(int y, int from, int shift) noexcept {
  if (from < 0) {
    return {};
  }
  const std::span<Cost> large = row_.across.first(index(grey_.width()));
  edge_penalties_across(grey_.row(y), grey_.row(from), shift, params_.penalties, large);
  return large;
}

// The path along row y, plus the straight one from row `from`, plus others.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::sum_axes(int y, int from, bool from_left, Front& front,
                                     std::span<const Cost> others, std::span<Cost> sums) noexcept {
  const std::span<Cost> large = row_.large.first(index(grey_.width()) + 1);
  edge_penalties_along(grey_.row(y), params_.penalties, large);
  const AxesRow<Cost> row{
      .costs = path_costs(y),
      .lanes = params_.lanes,
      .small = params_.penalties.small,
      .from_left = from_left,
      .large_along = from_left ? large.first(large.size() - 1) : large.subspan(1),
      .large_across = across(y, from, 0)};
  best::paths_of_axes(row, front.paths.first(index(row_size())), others, sums);
}

// done_ is the row before.
template <typename Cost, typename Sum>
std::span<Sum> SemiGlobal<Cost, Sum>::sum_row(int y) noexcept {
  if constexpr (kInPlace) {
    if (in_place()) {
      const std::span<Cost> sums = stored(0, y);
      sum_axes(y, y - 1, true, downward_[0], sums, sums);
      go_ahead(y);
      done_ = y;
      return sums;
    }
  }
  go_down(y);
  const std::size_t n = index(row_size());
  const std::span<Cost> large = row_.large.first(index(grey_.width()) + 1);
  edge_penalties_along(grey_.row(y), params_.penalties, large);
  best::paths_both_ways(path_costs(y), params_.lanes, params_.penalties.small,
                        large.first(large.size() - 1), large.subspan(1), row_.from_left.first(n),
                        row_.from_right.first(n));
  std::array<const Cost*, 2 + 2 * kMostShifts> rows{row_.from_left.data(), row_.from_right.data()};
  std::size_t count = 2;
  for (int k = 0; k < down_; ++k) {
    rows[count++] = downward_[index(k)].paths.data();
  }
  for (int k = 0; k < up_; ++k) {
    rows[count++] = stored(k, y).data();
  }
  best::sum_path_costs(std::span<const Cost* const>(rows).first(count), row_.sums.first(n));
  return row_.sums.first(n);
}

}  // namespace stof::dsp
