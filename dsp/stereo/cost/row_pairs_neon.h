#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/sad.h"

// The walk over a pair of rows that all sums of differences share, for the *_neon.cpp of this
// folder. differ(a, b) gives what sixteen pairs of pixels differ by; accumulate(differences, sums)
// and exchange(entering, leaving, sums) bring that onto sums.
namespace stof::dsp::neon {

inline void check_sizes(std::size_t n, std::size_t right, int lanes, std::size_t columns) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0);
  STOF_CHECK(right == n + static_cast<std::size_t>(lanes) - 1);
  STOF_CHECK(columns == n * static_cast<std::size_t>(lanes));
}

template <typename Sum, typename Differ>
void add_rows(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int lanes,
              std::span<Sum> columns, Differ differ) noexcept {
  const std::size_t n = left.size();
  check_sizes(n, right.size(), lanes, columns.size());
  for (std::size_t k = 0; k < n; ++k) {
    const uint8x16_t pixel = vdupq_n_u8(left[k]);
    const std::uint8_t* const candidates = right.data() + (n - 1 - k);
    Sum* const sums = columns.data() + k * static_cast<std::size_t>(lanes);
    for (int i = 0; i < lanes; i += kCostLanes) {
      accumulate(differ(pixel, vld1q_u8(candidates + i)), sums + i);
    }
  }
}

template <typename Sum, typename Differ>
void slide_rows(std::span<const std::uint8_t> new_left, std::span<const std::uint8_t> new_right,
                std::span<const std::uint8_t> old_left, std::span<const std::uint8_t> old_right,
                int lanes, std::span<Sum> columns, Differ differ) noexcept {
  const std::size_t n = new_left.size();
  check_sizes(n, new_right.size(), lanes, columns.size());
  STOF_CHECK(old_left.size() == n && old_right.size() == new_right.size());
  for (std::size_t k = 0; k < n; ++k) {
    const uint8x16_t entering = vdupq_n_u8(new_left[k]);
    const uint8x16_t leaving = vdupq_n_u8(old_left[k]);
    const std::size_t first = n - 1 - k;
    Sum* const sums = columns.data() + k * static_cast<std::size_t>(lanes);
    for (int i = 0; i < lanes; i += kCostLanes) {
      exchange(differ(entering, vld1q_u8(new_right.data() + first + i)),
               differ(leaving, vld1q_u8(old_right.data() + first + i)), sums + i);
    }
  }
}

}  // namespace stof::dsp::neon
