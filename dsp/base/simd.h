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
#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/arm/neon.h>
#endif

namespace stof::dsp::simd {

// The correctly rounded IEEE quotient, the same bits on every processor.
inline float32x4_t divide(float32x4_t a, float32x4_t b) noexcept { return a / b; }

// The correctly rounded IEEE square root, lane by lane where the vocabulary has none. v >= 0.
inline float32x4_t square_root(float32x4_t v) noexcept {
#if defined(__aarch64__)
  return vsqrtq_f32(v);
#else
  for (int lane = 0; lane < 4; ++lane) {
    v[lane] = std::sqrt(v[lane]);
  }
  return v;
#endif
}

// The smallest lane in every lane. Other processors than ARM have one instruction for 16 bits.
inline uint8x16_t smallest_everywhere(uint8x16_t v) noexcept {
#if defined(__aarch64__)
  return vdupq_n_u8(vminvq_u8(v));
#else
  const __m128i bytes = std::bit_cast<__m128i>(v);
  const __m128i pairs = _mm_min_epu8(bytes, _mm_srli_epi16(bytes, 8));  // high bytes become 0
  return std::bit_cast<uint8x16_t>(_mm_shuffle_epi8(_mm_minpos_epu16(pairs), _mm_setzero_si128()));
#endif
}
inline uint16x8_t smallest_everywhere(uint16x8_t v) noexcept {
#if defined(__aarch64__)
  return vdupq_n_u16(vminvq_u16(v));
#else
  const __m128i least = _mm_minpos_epu16(std::bit_cast<__m128i>(v));
  return std::bit_cast<uint16x8_t>(_mm_shuffle_epi8(least, _mm_set1_epi16(0x0100)));
#endif
}
inline uint32x4_t smallest_everywhere(uint32x4_t v) noexcept { return vdupq_n_u32(vminvq_u32(v)); }

// Nearest integer, ties to even, for 0 <= v < 2^22: adds and drops 1.5 * 2^23.
inline int32x4_t round_to_int(float32x4_t v) noexcept {
  const float32x4_t magic = vdupq_n_f32(12582912.0F);
  return vsubq_s32(vreinterpretq_s32_f32(vaddq_f32(v, magic)), vreinterpretq_s32_f32(magic));
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

// table[index], lane by lane; every index below 16. (vqtbl1q_u8 through SIMDe pays for the others.)
inline uint8x16_t look_up(uint8x16_t table, uint8x16_t index) noexcept {
#if defined(__SSSE3__)
  return std::bit_cast<uint8x16_t>(
      _mm_shuffle_epi8(std::bit_cast<__m128i>(table), std::bit_cast<__m128i>(index)));
#else
  return vqtbl1q_u8(table, index);
#endif
}

}  // namespace stof::dsp::simd
