#include "dsp/stereo/search/path_costs.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

template <typename Cost>
Cost saturated_sum(Cost a, Cost b) noexcept {
  const Cost sum = static_cast<Cost>(a + b);
  return sum < a ? kNoCost<Cost> : sum;
}

// One pixel. All three may be the same memory; before is empty where there is no pixel.
template <typename Cost>
void step(std::span<const Cost> costs, std::span<const Cost> before, Cost small, Cost large,
          std::span<Cost> paths) noexcept {
  if (before.empty()) {
    std::ranges::copy(costs, paths.begin());
    return;
  }
  const Cost lowest = *std::ranges::min_element(before);
  Cost previous = 0;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    Cost best = std::min(before[i], saturated_sum(lowest, large));
    if (i > 0) {
      best = std::min(best, saturated_sum(previous, small));
    }
    previous = before[i];
    if (i + 1 < costs.size()) {
      best = std::min(best, saturated_sum(before[i + 1], small));
    }
    paths[i] = saturated_sum(costs[i], static_cast<Cost>(best - lowest));
  }
}

template <typename Cost>
Cost total(Cost a, Cost b) noexcept {
  return sizeof(Cost) == 1 ? saturated_sum(a, b) : static_cast<Cost>(a + b);
}

}  // namespace

template <typename Cost>
void paths_along(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
                 bool from_left, std::span<Cost> paths) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = large.size();
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && costs.size() == n * count &&
             paths.size() == costs.size());
  std::span<const Cost> before;
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t x = from_left ? k : n - 1 - k;
    const std::span<Cost> pixel = paths.subspan(x * count, count);
    step(costs.subspan(x * count, count), before, small, large[x], pixel);
    before = pixel;
  }
}

template <typename Cost>
void paths_both_ways(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
                     std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  paths_along(costs, lanes, small, large_from_left, true, from_left);
  paths_along(costs, lanes, small, large_from_right, false, from_right);
}

template <typename Cost>
void paths_across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
                  Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const int n = static_cast<int>(large.size());
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && shift >= -1 && shift <= 1);
  STOF_CHECK(costs.size() == large.size() * count && before.size() == costs.size() &&
             paths.size() == costs.size());
  for (int x = 0; x < n; ++x) {
    const bool inside = x - shift >= 0 && x - shift < n;
    const std::size_t from = inside ? static_cast<std::size_t>(x - shift) * count : 0;
    const std::size_t at = static_cast<std::size_t>(x) * count;
    step(costs.subspan(at, count), before.subspan(from, inside ? count : 0), small,
         large[static_cast<std::size_t>(x)], paths.subspan(at, count));
  }
}

template <typename Cost>
void paths_of_axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
                   std::span<Cost> sums) noexcept {
  check_axes(row, front.size(), others.size(), sums.size());
  const std::size_t count = static_cast<std::size_t>(row.lanes);
  const std::size_t n = row.large_along.size();
  std::array<Cost, 256> buffer;
  const std::span<Cost> along = std::span<Cost>(buffer).first(count);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t x = row.from_left ? k : n - 1 - k;
    const std::span<const Cost> costs = row.costs.subspan(x * count, count);
    const std::span<Cost> across = front.subspan(x * count, count);
    const bool first_row = row.large_across.empty();
    step(costs, std::span<const Cost>(along).first(k == 0 ? 0 : count), row.small,
         row.large_along[x], along);
    step(costs, std::span<const Cost>(across).first(first_row ? 0 : count), row.small,
         first_row ? Cost{0} : row.large_across[x], across);
    for (std::size_t i = 0; i < count; ++i) {
      const Cost more = others.empty() ? Cost{0} : others[x * count + i];
      sums[x * count + i] = total(total(along[i], across[i]), more);
    }
  }
}

STOF_INSTANTIATE(PathsAlong, paths_along, std::uint8_t, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(PathsBothWays, paths_both_ways, std::uint8_t, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(PathsAcross, paths_across, std::uint8_t, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(PathsOfAxes, paths_of_axes, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::ref
