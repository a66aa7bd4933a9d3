#pragma once

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/cross_aggregation.h"

// The vector variants of cross_aggregation.h. Isa: Lanes<std::uint16_t> of base/lanes_neon.h or
// lanes_avx2.h and two functions more:
//   add_bytes<n>(costs, sums)      each lane of n vectors gets its byte
//   store_means(to, low, high, r)  of two vectors of sums; r is the area's reciprocal in every lane
namespace stof::dsp::cross_aggregation_body {

// kVectors vectors of candidates from `group` on, which stay in registers all along the row.
template <typename Isa, std::size_t kVectors>
void sum_group(std::span<const std::uint8_t> costs, std::size_t step, std::size_t group,
               std::uint16_t* sums) noexcept {
  typename Isa::V totals[kVectors] = {};
  for (std::size_t i = group; i < costs.size(); i += step) {
    Isa::template add_bytes<kVectors>(costs.data() + i, totals);
    for (std::size_t v = 0; v < kVectors; ++v) {
      Isa::store(sums + i + step + v * Isa::kLanes, totals[v]);
    }
  }
}

template <typename Isa>
void sum_along(std::span<const std::uint8_t> costs, int lanes,
               std::span<std::uint16_t> sums) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && sums.size() == costs.size() + step);
  for (std::size_t i = 0; i < step; i += Isa::kLanes) {
    Isa::store(sums.data() + i, Isa::all(0));
  }
  std::size_t group = 0;
  for (; group + 4 * Isa::kLanes <= step; group += 4 * Isa::kLanes) {
    sum_group<Isa, 4>(costs, step, group, sums.data());
  }
  for (; group < step; group += Isa::kLanes) {
    sum_group<Isa, 1>(costs, step, group, sums.data());
  }
}

// lanes a multiple of 2 kLanes.
template <typename Isa>
void cross_means(std::span<const CrossEnds> ends, int lanes,
                 std::span<std::uint8_t> means) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % static_cast<int>(2 * Isa::kLanes) == 0 && means.size() == ends.size() * step);
  for (std::size_t x = 0; x < ends.size(); ++x) {
    const std::uint16_t* const above = ends[x].above + x * step;
    const std::uint16_t* const below = ends[x].below + x * step;
    const auto reciprocal = Isa::all(static_cast<std::uint16_t>(ends[x].reciprocal));
    const auto sum = [&](std::size_t i) noexcept {
      return Isa::load(below + i) - Isa::load(above + i);
    };
    std::uint8_t* const to = means.data() + x * step;
    for (std::size_t i = 0; i < step; i += 2 * Isa::kLanes) {
      Isa::store_means(to + i, sum(i), sum(i + Isa::kLanes), reciprocal);
    }
  }
}

}  // namespace stof::dsp::cross_aggregation_body

namespace stof::dsp::STOF_VARIANT {

// NOLINTNEXTLINE(misc-definitions-in-headers): one source of a variant includes it
void sum_down(std::span<const std::uint16_t> sums, std::span<const std::uint8_t> left,
              std::span<const std::uint8_t> right, int lanes, std::span<const std::uint16_t> above,
              std::span<std::uint16_t> below) noexcept {
  using Isa = Lanes<std::uint16_t>;
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && right.size() == left.size() &&
             sums.size() == (left.size() + 1) * step && above.size() == left.size() * step &&
             below.size() == above.size());
  for (std::size_t x = 0; x < left.size(); ++x) {
    const std::uint16_t* const begin = sums.data() + (x - left[x]) * step;
    const std::uint16_t* const end = sums.data() + (x + right[x] + 1) * step;
    const std::uint16_t* const from = above.data() + x * step;
    std::uint16_t* const to = below.data() + x * step;
    for (std::size_t i = 0; i < step; i += Isa::kLanes) {
      Isa::store(to + i, Isa::load(from + i) + (Isa::load(end + i) - Isa::load(begin + i)));
    }
  }
}

}  // namespace stof::dsp::STOF_VARIANT
