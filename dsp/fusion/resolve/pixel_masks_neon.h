#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/simd.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"

// What the NEON kernels that mark pixels of a fused row have in common.
namespace stof::dsp::neon {

inline constexpr std::size_t kMaskLanes = 16;
inline constexpr std::size_t kMaskWord = 64;

template <typename Value>
uint8x16_t equals(uint8x16_t values, Value value) noexcept {
  return vceqq_u8(values, vdupq_n_u8(static_cast<std::uint8_t>(value)));
}

template <typename Value>
uint8x16_t load_bytes(std::span<const Value> row, std::size_t x) noexcept {
  static_assert(sizeof(Value) == 1);
  return vld1q_u8(reinterpret_cast<const std::uint8_t*>(&row[x]));  // NOLINT: an enum of bytes
}

// 12 length > from, the product saturated, which decides nothing else: where from is the largest
// number, length is 1 at most.
inline uint8x8_t is_wide(uint16x8_t from, uint16x8_t length) noexcept {
  static_assert(kNarrowShare == 12);
  const uint16x8_t three = vqaddq_u16(vqaddq_u16(length, length), length);
  const uint16x8_t six = vqaddq_u16(three, three);
  return vmovn_u16(vcgtq_u16(vqaddq_u16(six, six), from));
}

inline uint8x16_t missing(const Disparity* disparity) noexcept {
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  return vcombine_u8(vmovn_u16(vceqq_s16(vld1q_s16(&disparity->raw), none)),
                     vmovn_u16(vceqq_s16(vld1q_s16(&disparity[8].raw), none)));
}

// Of 64 pixels.
using Mask = std::array<uint8x16_t, kMaskWord / kMaskLanes>;

// A bit of each byte of 64, by sums of neighbours.
inline std::uint64_t packed(const Mask& masks) noexcept {
  static constexpr std::array<std::uint8_t, kMaskLanes> kBits{1, 2, 4, 8, 16, 32, 64, 128,
                                                              1, 2, 4, 8, 16, 32, 64, 128};
  const uint8x16_t bits = vld1q_u8(kBits.data());
  const uint8x16_t lower = vpaddq_u8(vandq_u8(masks[0], bits), vandq_u8(masks[1], bits));
  const uint8x16_t upper = vpaddq_u8(vandq_u8(masks[2], bits), vandq_u8(masks[3], bits));
  const uint8x16_t both = vpaddq_u8(lower, upper);
  return vgetq_lane_u64(vreinterpretq_u64_u8(vpaddq_u8(both, both)), 0);
}

inline void store_word(std::uint64_t bits, std::uint64_t* word) noexcept {
  vst1_u64(word, vdup_n_u64(bits));
}

}  // namespace stof::dsp::neon
