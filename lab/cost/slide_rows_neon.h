#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/row_pairs_neon.h"

// add_rows() of dsp/stereo/cost/row_pairs_neon.h where one pair of rows enters the sums and one
// leaves them: exchange(entering, leaving, sums) brings their differences onto sums.
namespace stof::dsp::neon {

// sums += entering - leaving.
inline void exchange(uint8x16_t entering, uint8x16_t leaving, std::uint16_t* sums) noexcept {
  const uint16x8_t low = vsubl_u8(vget_low_u8(entering), vget_low_u8(leaving));
  const uint16x8_t high = vsubl_u8(vget_high_u8(entering), vget_high_u8(leaving));
  vst1q_u16(sums, vaddq_u16(vld1q_u16(sums), low));
  vst1q_u16(sums + 8, vaddq_u16(vld1q_u16(sums + 8), high));
}
inline void exchange(uint8x16_t entering, uint8x16_t leaving, std::uint32_t* sums) noexcept {
  const int16x8_t low =
      vreinterpretq_s16_u16(vsubl_u8(vget_low_u8(entering), vget_low_u8(leaving)));
  const int16x8_t high =
      vreinterpretq_s16_u16(vsubl_u8(vget_high_u8(entering), vget_high_u8(leaving)));
  const auto slide = [](std::uint32_t* at, int16x4_t change) noexcept {
    vst1q_u32(at, vaddq_u32(vld1q_u32(at), vreinterpretq_u32_s32(vmovl_s16(change))));
  };
  slide(sums, vget_low_s16(low));
  slide(sums + 4, vget_high_s16(low));
  slide(sums + 8, vget_low_s16(high));
  slide(sums + 12, vget_high_s16(high));
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
