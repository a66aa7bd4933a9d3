#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

// The NEON vocabulary of *_neon.cpp files: the real one on ARM, SIMDe's on other processors.
// Missing in SIMDe 0.7.4 (do not use): vabal_u8, vabal_high_u8, vabdl_high_u8, vqrdmlahq_s16,
// vcvtnq_s32_f32, vsqrtq_f32, vdivq_f32, vst1q_u8_x2, vsliq_n_u16, vqshlq_n_s16. Reciprocal
// estimates differ between processors and are banned for that reason.
#if defined(__aarch64__)
#include <arm_neon.h>
#else
// No MMX: its registers are those of the x87. Behind a kernel that used them long double, and
// libraries that compute with it, get not a number.
#define SIMDE_X86_MMX_NO_NATIVE
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/arm/neon.h>
#if defined(SIMDE_X86_MMX_NATIVE)
#error "SIMDe uses MMX: include dsp/base/simd.h before any header of SIMDe"
#endif
#endif

namespace stof::dsp::simd {

// The correctly rounded IEEE quotient, the same bits on every processor.
inline float32x4_t divide(float32x4_t a, float32x4_t b) noexcept { return a / b; }

// The correctly rounded IEEE square root, lane by lane where the vocabulary has none. v >= 0.
inline float32x4_t square_root(float32x4_t v) noexcept {
#if defined(__aarch64__)
  return vsqrtq_f32(v);
#elif defined(__SSE2__)
  return std::bit_cast<float32x4_t>(_mm_sqrt_ps(std::bit_cast<__m128>(v)));
#else
  for (int lane = 0; lane < 4; ++lane) {
    v[lane] = std::sqrt(v[lane]);
  }
  return v;
#endif
}

// Nearest integer, ties to even, for -2^22 <= v < 2^22: other processors than ARM add and drop
// 1.5 * 2^23.
inline int32x4_t round_to_int(float32x4_t v) noexcept {
#if defined(__aarch64__)
  return vcvtnq_s32_f32(v);
#else
  const float32x4_t magic = vdupq_n_f32(12582912.0F);
  return vsubq_s32(vreinterpretq_s32_f32(vaddq_f32(v, magic)), vreinterpretq_s32_f32(magic));
#endif
}

// (a b + 2^14) >> 15, lane by lane; not both -32768.
inline int16x8_t scaled_product(int16x8_t a, int16x8_t b) noexcept {
#if defined(__SSSE3__)
  return std::bit_cast<int16x8_t>(
      _mm_mulhrs_epi16(std::bit_cast<__m128i>(a), std::bit_cast<__m128i>(b)));
#else
  return vqrdmulhq_s16(a, b);
#endif
}

// (a b) >> 15, lane by lane; not both -32768.
inline int16x8_t product_above(int16x8_t a, int16x8_t b) noexcept {
#if defined(__SSE2__)
  const __m128i x = std::bit_cast<__m128i>(a);
  const __m128i y = std::bit_cast<__m128i>(b);
  return std::bit_cast<int16x8_t>(_mm_or_si128(_mm_slli_epi16(_mm_mulhi_epi16(x, y), 1),
                                               _mm_srli_epi16(_mm_mullo_epi16(x, y), 15)));
#else
  return vqdmulhq_s16(a, b);
#endif
}

// table[index], lane by lane; every index below 16. (vqtbl1q_u8 through SIMDe pays for the others.)
inline uint8x16_t look_up(uint8x16_t table, uint8x16_t index) noexcept {
#if defined(__SSSE3__)
  return std::bit_cast<uint8x16_t>(
      _mm_shuffle_epi8(std::bit_cast<__m128i>(table), std::bit_cast<__m128i>(index)));
#else
  return vqtbl1q_u8(table, index);
#endif
}

// |a - b| of values up to 127, for which other processors than ARM have a shorter way.
inline uint8x16_t difference_of_small(uint8x16_t a, uint8x16_t b) noexcept {
#if defined(__SSSE3__)
  return std::bit_cast<uint8x16_t>(
      _mm_abs_epi8(_mm_sub_epi8(std::bit_cast<__m128i>(a), std::bit_cast<__m128i>(b))));
#else
  return vabdq_u8(a, b);
#endif
}

// low, high += 8 (a - b), of values up to 127.
inline void add_eight_times(uint8x16_t a, uint8x16_t b, uint16x8_t& low,
                            uint16x8_t& high) noexcept {
#if defined(__SSSE3__)
  const __m128i by = _mm_set1_epi16(static_cast<std::int16_t>(0xF808));  // 8 of a, -8 of b
  const __m128i first = std::bit_cast<__m128i>(a);
  const __m128i second = std::bit_cast<__m128i>(b);
  low = vaddq_u16(
      low, std::bit_cast<uint16x8_t>(_mm_maddubs_epi16(_mm_unpacklo_epi8(first, second), by)));
  high = vaddq_u16(
      high, std::bit_cast<uint16x8_t>(_mm_maddubs_epi16(_mm_unpackhi_epi8(first, second), by)));
#else
  const int8x8_t eight = vdup_n_s8(8);
  const int8x16_t change = vreinterpretq_s8_u8(vsubq_u8(a, b));
  low = vreinterpretq_u16_s16(vmlal_s8(vreinterpretq_s16_u16(low), vget_low_s8(change), eight));
  high = vreinterpretq_u16_s16(vmlal_s8(vreinterpretq_s16_u16(high), vget_high_s8(change), eight));
#endif
}

}  // namespace stof::dsp::simd
