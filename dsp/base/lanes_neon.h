#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "dsp/base/simd.h"

// Vectors of u8, u16 and u32 lanes by the same names: for kernels of several kinds of sums, and for
// x_body.h headers, which NEON and AVX2 (base/lanes_avx2.h) share. + - & | work lane by lane; a
// true mask is all ones.
namespace stof::dsp::neon {

// The variant whose kernels an x_body.h defines, and the one that does what they leave.
#define STOF_VARIANT neon
#define STOF_NARROWER ref

template <typename Lane>
struct Lanes;
template <typename Lane>
inline constexpr auto kLaneNumbers = [] {
  std::array<Lane, 16 / sizeof(Lane)> numbers{};
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    numbers[k] = static_cast<Lane>(k);
  }
  return numbers;
}();

template <>
struct Lanes<std::uint8_t> {
  using Lane = std::uint8_t;
  using V = uint8x16_t;
  static constexpr std::size_t kLanes = 16;

  static V load(const Lane* p) noexcept { return vld1q_u8(p); }
  static void store(Lane* p, V v) noexcept { vst1q_u8(p, v); }
  static V all(Lane v) noexcept { return vdupq_n_u8(v); }
  static V numbers() noexcept { return load(kLaneNumbers<Lane>.data()); }
  static V add_saturated(V a, V b) noexcept { return vqaddq_u8(a, b); }
  static V difference(V a, V b) noexcept { return vabdq_u8(a, b); }
  static V smaller(V a, V b) noexcept { return vminq_u8(a, b); }
  static V larger(V a, V b) noexcept { return vmaxq_u8(a, b); }
  static V less(V a, V b) noexcept { return vcltq_u8(a, b); }
  static V at_most(V a, V b) noexcept { return vcleq_u8(a, b); }
  static V equal(V a, V b) noexcept { return vceqq_u8(a, b); }
  static V select(V mask, V a, V b) noexcept { return vbslq_u8(mask, a, b); }
  // Lane i holds what was in lane i - 1, or i + 1; a lane of the neighbouring vector ends the gap.
  static V one_up(V before, V v) noexcept { return vextq_u8(before, v, 15); }
  static V one_down(V v, V after) noexcept { return vextq_u8(v, after, 1); }
  // From lane kFirst of `v` on, then lanes of `after`.
  template <int kFirst>
  static V joined(V v, V after) noexcept {
    return vextq_u8(v, after, kFirst);
  }
  static Lane smallest(V v) noexcept { return vminvq_u8(v); }
  static Lane largest(V v) noexcept { return vmaxvq_u8(v); }
  // The smallest lane in every lane. Other processors than ARM have one instruction for 16 bits.
  static V lowest(V v) noexcept {
#if defined(__aarch64__)
    return all(smallest(v));
#else
    const __m128i bytes = std::bit_cast<__m128i>(v);
    const __m128i pairs = _mm_min_epu8(bytes, _mm_srli_epi16(bytes, 8));  // high bytes become 0
    return std::bit_cast<V>(_mm_shuffle_epi8(_mm_minpos_epu16(pairs), _mm_setzero_si128()));
#endif
  }
};

template <>
struct Lanes<std::uint16_t> {
  using Lane = std::uint16_t;
  using V = uint16x8_t;
  static constexpr std::size_t kLanes = 8;

  static V load(const Lane* p) noexcept { return vld1q_u16(p); }
  static void store(Lane* p, V v) noexcept { vst1q_u16(p, v); }
  static V all(Lane v) noexcept { return vdupq_n_u16(v); }
  static V numbers() noexcept { return load(kLaneNumbers<Lane>.data()); }
  static V add_saturated(V a, V b) noexcept { return vqaddq_u16(a, b); }
  static V difference(V a, V b) noexcept { return vabdq_u16(a, b); }
  static V smaller(V a, V b) noexcept { return vminq_u16(a, b); }
  static V larger(V a, V b) noexcept { return vmaxq_u16(a, b); }
  static V less(V a, V b) noexcept { return vcltq_u16(a, b); }
  static V at_most(V a, V b) noexcept { return vcleq_u16(a, b); }
  static V equal(V a, V b) noexcept { return vceqq_u16(a, b); }
  static V select(V mask, V a, V b) noexcept { return vbslq_u16(mask, a, b); }
  static V one_up(V before, V v) noexcept { return vextq_u16(before, v, 7); }
  static V one_down(V v, V after) noexcept { return vextq_u16(v, after, 1); }
  // From lane kFirst of `v` on, then lanes of `after`.
  template <int kFirst>
  static V joined(V v, V after) noexcept {
    return vextq_u16(v, after, kFirst);
  }
  static Lane smallest(V v) noexcept { return vminvq_u16(v); }
  static Lane largest(V v) noexcept { return vmaxvq_u16(v); }
  static V subtract_saturated(V a, V b) noexcept { return vqsubq_u16(a, b); }
  static V rounded_mean(V a, V b) noexcept { return vrhaddq_u16(a, b); }
  // Signed: a / 16, rounded down; (a b + 2^14) >> 15.
  static V signed_sixteenth(V a) noexcept {
    return vreinterpretq_u16_s16(vshrq_n_s16(vreinterpretq_s16_u16(a), 4));
  }
  static V signed_scaled_product(V a, V b) noexcept {
    return vreinterpretq_u16_s16(
        simd::scaled_product(vreinterpretq_s16_u16(a), vreinterpretq_s16_u16(b)));
  }
  // Bytes, a lane each.
  static V load_bytes(const std::uint8_t* p) noexcept { return vmovl_u8(vld1_u8(p)); }
  static void store_bytes(std::uint8_t* p, V v) noexcept { vst1_u8(p, vmovn_u16(v)); }
  static bool any(V mask) noexcept {
    const uint64x2_t words = vreinterpretq_u64_u16(mask);
    return (vgetq_lane_u64(words, 0) | vgetq_lane_u64(words, 1)) != 0;
  }
  static V lowest(V v) noexcept {
#if defined(__aarch64__)
    return all(smallest(v));
#else
    const __m128i least = _mm_minpos_epu16(std::bit_cast<__m128i>(v));
    return std::bit_cast<V>(_mm_shuffle_epi8(least, _mm_set1_epi16(0x0100)));
#endif
  }
};

template <>
struct Lanes<std::uint32_t> {
  using Lane = std::uint32_t;
  using V = uint32x4_t;
  static constexpr std::size_t kLanes = 4;

  static V load(const Lane* p) noexcept { return vld1q_u32(p); }
  static void store(Lane* p, V v) noexcept { vst1q_u32(p, v); }
  static V all(Lane v) noexcept { return vdupq_n_u32(v); }
  static V numbers() noexcept { return load(kLaneNumbers<Lane>.data()); }
  static V add_saturated(V a, V b) noexcept { return vqaddq_u32(a, b); }
  static V difference(V a, V b) noexcept { return vabdq_u32(a, b); }
  static V smaller(V a, V b) noexcept { return vminq_u32(a, b); }
  static V larger(V a, V b) noexcept { return vmaxq_u32(a, b); }
  static V less(V a, V b) noexcept { return vcltq_u32(a, b); }
  static V at_most(V a, V b) noexcept { return vcleq_u32(a, b); }
  static V equal(V a, V b) noexcept { return vceqq_u32(a, b); }
  static V select(V mask, V a, V b) noexcept { return vbslq_u32(mask, a, b); }
  static V one_up(V before, V v) noexcept { return vextq_u32(before, v, 3); }
  static V one_down(V v, V after) noexcept { return vextq_u32(v, after, 1); }
  static Lane smallest(V v) noexcept { return vminvq_u32(v); }
  static Lane largest(V v) noexcept { return vmaxvq_u32(v); }
  static V lowest(V v) noexcept { return all(smallest(v)); }
};

}  // namespace stof::dsp::neon
