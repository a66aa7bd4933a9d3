#pragma once

#include <array>
#include <span>

#include "dsp/base/check.h"
#include "dsp/stereo/search/path_step_body.h"

// The NEON and the AVX2 variant of path_costs.h: walks over any Isa (as in path_step_body.h), and
// the kernels of the variant whose lanes are included.
namespace stof::dsp::path_costs_body {

template <typename Isa, std::size_t kVectors, typename Cost>
void walk(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
          bool from_left, std::span<Cost> paths) noexcept {
  const Step<Isa, kVectors> step(lanes, small);
  const std::size_t n = large.size();
  const std::size_t count = step.lanes();
  std::size_t before = (from_left ? 0 : n - 1) * count;
  auto lowest = step.start(costs.data() + before, store_to<Isa>(paths.data() + before));
  for (std::size_t k = 1; k < n; ++k) {
    const std::size_t x = from_left ? k : n - 1 - k;
    lowest = step.go(costs.data() + x * count, paths.data() + before, lowest, large[x],
                     store_to<Isa>(paths.data() + x * count));
    before = x * count;
  }
}

// The two ways do not wait for each other: what one waits for is the other's time.
template <typename Isa, std::size_t kVectors, typename Cost>
void walk_both(std::span<const Cost> costs, int lanes, Cost small,
               std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
               std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  const Step<Isa, kVectors> step(lanes, small);
  const std::size_t n = large_from_left.size();
  const std::size_t count = step.lanes();
  std::size_t left = 0;
  std::size_t right = (n - 1) * count;
  auto left_lowest = step.start(costs.data() + left, store_to<Isa>(from_left.data() + left));
  auto right_lowest = step.start(costs.data() + right, store_to<Isa>(from_right.data() + right));
  for (std::size_t k = 1; k < n; ++k) {
    left_lowest = step.go(costs.data() + left + count, from_left.data() + left, left_lowest,
                          large_from_left[k], store_to<Isa>(from_left.data() + left + count));
    right_lowest =
        step.go(costs.data() + right - count, from_right.data() + right, right_lowest,
                large_from_right[n - 1 - k], store_to<Isa>(from_right.data() + right - count));
    left += count;
    right -= count;
  }
}

template <typename Isa, std::size_t kVectors, typename Cost>
void cross(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
           Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  const Step<Isa, kVectors> step(lanes, small);
  const std::size_t count = step.lanes();
  const int n = static_cast<int>(large.size());
  for (int x = 0; x < n; ++x) {
    const std::size_t at = static_cast<std::size_t>(x) * count;
    if (x - shift < 0 || x - shift >= n) {
      step.start(costs.data() + at, store_to<Isa>(paths.data() + at));
      continue;
    }
    const Cost* const from = before.data() + static_cast<std::size_t>(x - shift) * count;
    step.go(costs.data() + at, from, step.lowest(from), large[static_cast<std::size_t>(x)],
            store_to<Isa>(paths.data() + at));
  }
}

// For sums over paths.
template <typename Isa>
typename Isa::V total(typename Isa::V a, typename Isa::V b) noexcept {
  if constexpr (sizeof(typename Isa::Lane) == 1) {
    return Isa::add_saturated(a, b);
  } else {
    return a + b;
  }
}

// The paths along the row wait for one another; those across rows do not wait and fill the time.
template <typename Isa, std::size_t kVectors, typename Cost>
void both_axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
               std::span<Cost> sums) noexcept {
  const Step<Isa, kVectors> step(row.lanes, row.small);
  const std::size_t n = row.large_along.size();
  const std::size_t count = step.lanes();
  std::array<Cost, kMostLanes> along;  // of the pixel before
  auto lowest = Isa::all(Cost{0});
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t x = row.from_left ? k : n - 1 - k;
    const Cost* const costs = row.costs.data() + x * count;
    Cost* const across = front.data() + x * count;
    const auto keep = store_to<Isa>(along.data());
    lowest = k == 0 ? step.start(costs, keep)
                    : step.go(costs, along.data(), lowest, row.large_along[x], keep);
    const Cost* const more = others.empty() ? nullptr : others.data() + x * count;
    Cost* const sum = sums.data() + x * count;
    const auto add_up = [&](std::size_t i, typename Isa::V path) noexcept {
      Isa::store(across + i, path);
      const typename Isa::V two = total<Isa>(path, Isa::load(along.data() + i));
      Isa::store(sum + i, more == nullptr ? two : total<Isa>(two, Isa::load(more + i)));
    };
    if (row.large_across.empty()) {
      step.start(costs, add_up);
    } else {
      step.go(costs, across, step.lowest(across), row.large_across[x], add_up);
    }
  }
}

template <typename Isa, typename Cost>
void along(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
           bool from_left, std::span<Cost> paths) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && paths.size() == costs.size() &&
             costs.size() == large.size() * static_cast<std::size_t>(lanes));
  if (large.empty()) {
    return;
  }
  with_known_count<Isa>(lanes, [&]<std::size_t kVectors>() noexcept {
    walk<Isa, kVectors>(costs, lanes, small, large, from_left, paths);
  });
}

template <typename Isa, typename Cost>
void both_ways(std::span<const Cost> costs, int lanes, Cost small,
               std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
               std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && from_left.size() == costs.size() &&
             from_right.size() == costs.size() &&
             large_from_right.size() == large_from_left.size() &&
             costs.size() == large_from_left.size() * static_cast<std::size_t>(lanes));
  if (large_from_left.empty()) {
    return;
  }
  with_known_count<Isa>(lanes, [&]<std::size_t kVectors>() noexcept {
    walk_both<Isa, kVectors>(costs, lanes, small, large_from_left, large_from_right, from_left,
                             from_right);
  });
}

template <typename Isa, typename Cost>
void across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
            Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && shift >= -1 && shift <= 1 &&
             costs.size() == large.size() * static_cast<std::size_t>(lanes) &&
             before.size() == costs.size() && paths.size() == costs.size());
  with_known_count<Isa>(lanes, [&]<std::size_t kVectors>() noexcept {
    cross<Isa, kVectors>(costs, before, shift, lanes, small, large, paths);
  });
}

template <typename Isa, typename Cost>
void axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
          std::span<Cost> sums) noexcept {
  check_axes(row, front.size(), others.size(), sums.size());
  with_known_count<Isa>(row.lanes, [&]<std::size_t kVectors>() noexcept {
    both_axes<Isa, kVectors>(row, front, others, sums);
  });
}

}  // namespace stof::dsp::path_costs_body

namespace stof::dsp::STOF_VARIANT {
namespace {

template <typename Cost>
struct Isa : Lanes<Cost> {};

// Whether `lanes` end inside of a vector: vectors may be longer than kCostLanes.
template <typename Cost>
constexpr bool end_inside(int lanes) noexcept {
  return Isa<Cost>::kLanes > kCostLanes && lanes % static_cast<int>(Isa<Cost>::kLanes) != 0;
}

}  // namespace

template <typename Cost>
void paths_along(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
                 bool from_left, std::span<Cost> paths) noexcept {
  path_costs_body::along<Isa<Cost>>(costs, lanes, small, large, from_left, paths);
}

template <typename Cost>
void paths_both_ways(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
                     std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  if (end_inside<Cost>(lanes)) {
    STOF_NARROWER::paths_both_ways(costs, lanes, small, large_from_left, large_from_right,
                                   from_left, from_right);
    return;
  }
  path_costs_body::both_ways<Isa<Cost>>(costs, lanes, small, large_from_left, large_from_right,
                                        from_left, from_right);
}

template <typename Cost>
void paths_across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
                  Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  if (end_inside<Cost>(lanes)) {
    STOF_NARROWER::paths_across(costs, before, shift, lanes, small, large, paths);
    return;
  }
  path_costs_body::across<Isa<Cost>>(costs, before, shift, lanes, small, large, paths);
}

template <typename Cost>
void paths_of_axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
                   std::span<Cost> sums) noexcept {
  if (end_inside<Cost>(row.lanes)) {
    STOF_NARROWER::paths_of_axes(row, front, others, sums);
    return;
  }
  path_costs_body::axes<Isa<Cost>>(row, front, others, sums);
}

}  // namespace stof::dsp::STOF_VARIANT
