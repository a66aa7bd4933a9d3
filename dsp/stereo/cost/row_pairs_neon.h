#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/sad.h"

// The walk over a pair of rows that all sums of differences share, for *_neon.cpp: differ(a, b)
// gives what sixteen pairs of pixels differ by, accumulate(differences, sums) brings that onto
// sums.
namespace stof::dsp::neon {

// sums += values, sixteen of them.
inline void accumulate(uint8x16_t values, std::uint16_t* sums) noexcept {
  vst1q_u16(sums, vaddw_u8(vld1q_u16(sums), vget_low_u8(values)));
  vst1q_u16(sums + 8, vaddw_u8(vld1q_u16(sums + 8), vget_high_u8(values)));
}
inline void accumulate(uint8x16_t values, std::uint32_t* sums) noexcept {
  const uint16x8_t low = vmovl_u8(vget_low_u8(values));
  const uint16x8_t high = vmovl_u8(vget_high_u8(values));
  vst1q_u32(sums, vaddw_u16(vld1q_u32(sums), vget_low_u16(low)));
  vst1q_u32(sums + 4, vaddw_u16(vld1q_u32(sums + 4), vget_high_u16(low)));
  vst1q_u32(sums + 8, vaddw_u16(vld1q_u32(sums + 8), vget_low_u16(high)));
  vst1q_u32(sums + 12, vaddw_u16(vld1q_u32(sums + 12), vget_high_u16(high)));
}

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

}  // namespace stof::dsp::neon
