#pragma once

#include <cstdint>

#include "dsp/base/simd.h"

// Sixteen u8 values onto sixteen u16 or u32 sums, for the *_neon.cpp of this folder.
namespace stof::dsp::neon {

// sums += values.
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

}  // namespace stof::dsp::neon
