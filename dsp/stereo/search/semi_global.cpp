#include "dsp/stereo/search/semi_global.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/search/path.h"
#include "dsp/stereo/search/sum_paths.h"

namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

int shifts_down(int directions) noexcept {
  constexpr std::array<int, 9> kShiftsDown{0, 0, 0, 0, 1, 3, 3, 3, 3};
  return kShiftsDown[size(directions)];
}
int shifts_up(int directions) noexcept { return directions == 5 ? 0 : shifts_down(directions); }

// The straight one first.
constexpr std::array<int, 3> kShifts{0, -1, 1};

}  // namespace

template <typename Cost, typename Sum>
std::size_t SemiGlobal<Cost, Sum>::bytes_needed(const PathParams<Cost>& params,
                                                int width) noexcept {
  const std::size_t row = size(width) * size(params.lanes);
  const std::size_t down = size(shifts_down(params.directions));
  const std::size_t up = size(shifts_up(params.directions));
  return Arena::bytes_for<Cost>(row * size(kKept)) + Arena::bytes_for<Cost>(row * up * kStripe) +
         2 * std::max(down, up) * Arena::bytes_for<Cost>(row) + 2 * Arena::bytes_for<Cost>(row) +
         Arena::bytes_for<Cost>(size(width) + 1) + Arena::bytes_for<Sum>(row) +
         Arena::bytes_for<Cost>(params.guided ? row : 0);
}

template <typename Cost, typename Sum>
SemiGlobal<Cost, Sum>::SemiGlobal(const PathParams<Cost>& params, int width, Arena& arena) noexcept
    : params_(params), down_(shifts_down(params.directions)), up_(shifts_up(params.directions)) {
  STOF_CHECK(valid(params.directions) && params.lanes % kCostLanes == 0);
  const std::size_t row = size(width) * size(params.lanes);
  costs_ = arena.take<Cost>(row * size(kKept));
  upwards_ = arena.take<Cost>(row * size(up_) * kStripe);
  for (Front& front : fronts_) {
    for (int k = 0; k < std::max(down_, up_); ++k) {
      front.paths[size(k)] = arena.take<Cost>(row);
    }
  }
  from_left_ = arena.take<Cost>(row);
  from_right_ = arena.take<Cost>(row);
  large_ = arena.take<Cost>(size(width) + 1);
  sums_ = arena.take<Sum>(row);
  masked_ = arena.take<Cost>(params.guided ? row : 0);
}

template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::start(ImageView<const std::uint8_t> grey, CostSource<Cost>& costs,
                                  Guide guide) noexcept {
  STOF_CHECK(guide.empty() || (params_.guided && same_size(guide, grey)));
  grey_ = grey;
  source_ = &costs;
  guide_ = guide;
  STOF_CHECK(size(row_size()) <= sums_.size());
  kept_ = {};
  stripe_ = -1;
}

template <typename Cost, typename Sum>
std::span<Sum> SemiGlobal<Cost, Sum>::sums(int y) noexcept {
  STOF_CHECK(y >= 0 && y < grey_.height());
  if (y / kStripe != stripe_) {
    open_stripe(y / kStripe);
  } else if (y < done_) {
    approach();
  }
  while (done_ < y) {
    ++done_;
    advance(done_, done_ - 1, fronts_[size((done_ + 1) % 2)], fronts_[size(done_ % 2)]);
  }
  sum_row(y);
  return sums_.first(size(row_size()));
}

template <typename Cost, typename Sum>
std::span<Cost> SemiGlobal<Cost, Sum>::kept(int y) const noexcept {
  return costs_.subspan(size(y % kKept) * size(row_size()), size(row_size()));
}

// Valid until the next call.
template <typename Cost, typename Sum>
std::span<const Cost> SemiGlobal<Cost, Sum>::path_costs(int y) noexcept {
  if (guide_.empty() || !narrows(guide_.row(y), params_.lanes)) {
    return kept(y);
  }
  const std::span<Cost> masked = masked_.first(size(row_size()));
  best::mask_costs(std::span<const Cost>(kept(y)), guide_.row(y), params_.lanes, masked);
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

// The costs of the stripe and its surroundings, and all upward paths of its rows.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::open_stripe(int stripe) noexcept {
  stripe_ = stripe;
  const int begin = stripe * kStripe;
  const int end = std::min(begin + kStripe, grey_.height());
  const int last = (up_ == 0 ? end : std::min(end + kApproach, grey_.height())) - 1;
  keep_costs({down_ == 0 ? begin : std::max(begin - kApproach, 0), last + 1});
  if (up_ > 0) {
    for (int y = last; y >= begin; --y) {
      Front here = fronts_[size(y % 2)];
      Front before = fronts_[size((y + 1) % 2)];
      for (int k = 0; k < up_; ++k) {
        const auto stored = [&](int row) noexcept {
          return upwards_.subspan(size(k * kStripe + row - begin) * size(row_size()),
                                  size(row_size()));
        };
        here.paths[size(k)] = y < end ? stored(y) : here.paths[size(k)];
        before.paths[size(k)] = y + 1 < end ? stored(y + 1) : before.paths[size(k)];
      }
      advance(y, y < last ? y + 1 : -1, before, here);
    }
  }
  approach();
}

// Downward paths from above the stripe to its first row.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::approach() noexcept {
  const int begin = stripe_ * kStripe;
  const int first = down_ == 0 ? begin : std::max(begin - kApproach, 0);
  for (done_ = first; done_ <= begin; ++done_) {
    advance(done_, done_ > first ? done_ - 1 : -1, fronts_[size((done_ + 1) % 2)],
            fronts_[size(done_ % 2)]);
  }
  done_ = begin;
}

// Paths of row y that come from row `from`, whose own are `before`; from -1 when y is the first.
template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::advance(int y, int from, Front before, const Front& here) noexcept {
  const int count = from > y ? up_ : down_;
  const std::span<const Cost> costs = path_costs(y);
  const std::size_t n = size(row_size());
  for (int k = 0; k < (from < 0 ? std::max(down_, up_) : count); ++k) {
    const std::span<Cost> paths = here.paths[size(k)].first(n);
    if (from < 0) {
      std::ranges::copy(costs, paths.begin());
      continue;
    }
    const std::span<Cost> large = large_.first(size(grey_.width()));
    edge_penalties_across(grey_.row(y), grey_.row(from), kShifts[size(k)], params_.penalties,
                          large);
    best::paths_across(costs, before.paths[size(k)].first(n), kShifts[size(k)], params_.lanes,
                       params_.penalties.small, large, paths);
  }
}

template <typename Cost, typename Sum>
void SemiGlobal<Cost, Sum>::sum_row(int y) noexcept {
  const std::size_t n = size(row_size());
  const std::span<Cost> large = large_.first(size(grey_.width()) + 1);
  edge_penalties_along(grey_.row(y), params_.penalties, large);
  best::paths_both_ways(path_costs(y), params_.lanes, params_.penalties.small,
                        large.first(large.size() - 1), large.subspan(1), from_left_.first(n),
                        from_right_.first(n));
  std::array<const Cost*, 2 + 2 * kMostShifts> rows{from_left_.data(), from_right_.data()};
  std::size_t count = 2;
  for (int k = 0; k < down_; ++k) {
    rows[count++] = fronts_[size(y % 2)].paths[size(k)].data();
  }
  for (int k = 0; k < up_; ++k) {
    const int row = k * kStripe + y - stripe_ * kStripe;
    rows[count++] = upwards_.subspan(size(row) * n).data();
  }
  best::sum_paths(std::span<const Cost* const>(rows).first(count), sums_.first(n));
}

template class SemiGlobal<std::uint8_t, std::uint8_t>;
template class SemiGlobal<std::uint8_t, std::uint16_t>;
template class SemiGlobal<std::uint16_t, std::uint16_t>;

}  // namespace stof::dsp
