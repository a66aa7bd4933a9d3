#pragma once

#include <cmath>

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

// Nearest integer, ties to even, for 0 <= v < 2^22: adds and drops 1.5 * 2^23.
inline int32x4_t round_to_int(float32x4_t v) noexcept {
  const float32x4_t magic = vdupq_n_f32(12582912.0F);
  return vsubq_s32(vreinterpretq_s32_f32(vaddq_f32(v, magic)), vreinterpretq_s32_f32(magic));
}

}  // namespace stof::dsp::simd
