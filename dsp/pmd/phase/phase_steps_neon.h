#pragma once

#include <cstdint>

#include "dsp/base/simd.h"
#include "dsp/pmd/phase/phase.h"

// For phase_neon.cpp alone: the steps that depend on how many bits the samples have.
namespace stof::dsp::neon::phase_steps {

struct Quads {
  float32x4_t low;
  float32x4_t high;
};

// The lower and the upper halves of 32-bit lanes.
inline uint16x8_t lower(uint32x4_t low, uint32x4_t high) noexcept {
  return vuzp1q_u16(vreinterpretq_u16_u32(low), vreinterpretq_u16_u32(high));
}
inline uint16x8_t upper(uint32x4_t low, uint32x4_t high) noexcept {
  return vuzp2q_u16(vreinterpretq_u16_u32(low), vreinterpretq_u16_u32(high));
}

// sqrt(I^2 + Q^2) rounded down, or, next to a whole number, to that: half a unit away from it whole
// numbers then tell whether one more is nearer.
inline uint32x4_t root_estimate(float32x4_t mn, float32x4_t mx) noexcept {
  return vcvtq_u32_f32(simd::square_root(vfmaq_f32(vmulq_f32(mx, mx), mn, mn)));
}

// Limits in every lane.
struct Limits {
  explicit Limits(const PhaseLimits& limits) noexcept
      : saturation(vdupq_n_u16(limits.saturation)),
        lowest(vdupq_n_u16(limits.lowest)),
        dark(vdupq_n_u16(limits.dark)),
        min_amp2(vdupq_n_u16(limits.min_amp2)),
        stray_i(vdupq_n_s16(limits.stray_i)),
        stray_q(vdupq_n_s16(limits.stray_q)),
        ratio(limits.ratio_q16),
        asymmetry_base(limits.asymmetry_base),
        asymmetry_slope(limits.asymmetry_slope_q8) {}

  uint16x8_t saturation;
  uint16x8_t lowest;
  uint16x8_t dark;
  uint16x8_t min_amp2;
  int16x8_t stray_i;
  int16x8_t stray_q;
  std::uint32_t ratio;
  std::uint32_t asymmetry_base;
  std::uint32_t asymmetry_slope;
};

struct Samples {
  uint16x8_t a0;
  uint16x8_t a1;
  uint16x8_t a2;
  uint16x8_t a3;
};

// Whether no two samples can be uneven enough for kPmdAsymmetric.
inline bool never_asymmetric(const PhaseLimits& limits) noexcept {
  return limits.asymmetry_base == 0xFFFFFFFF;
}

// Any samples.
struct Wide {
  static constexpr bool kMayBeAsymmetric = true;

  static Samples limited(const Samples& a) noexcept {
    const uint16x8_t top = vdupq_n_u16(32767);
    return {vminq_u16(a.a0, top), vminq_u16(a.a1, top), vminq_u16(a.a2, top), vminq_u16(a.a3, top)};
  }

  // a - b without stray light.
  static int16x8_t less_stray(uint16x8_t a, uint16x8_t b, int16x8_t stray) noexcept {
    const int16x8_t difference = vreinterpretq_s16_u16(vsubq_u16(a, b));
    return vmaxq_s16(vqsubq_s16(difference, stray), vdupq_n_s16(-32767));
  }

  static uint16x8_t magnitude(const Quads& mn, const Quads& mx, int16x8_t i, int16x8_t q) noexcept {
    const int16x4_t i_low = vget_low_s16(i);
    const int16x4_t q_low = vget_low_s16(q);
    const int16x4_t i_high = vget_high_s16(i);
    const int16x4_t q_high = vget_high_s16(q);
    return lower(
        nearest(root_estimate(mn.low, mx.low), vmlal_s16(vmull_s16(i_low, i_low), q_low, q_low)),
        nearest(root_estimate(mn.high, mx.high),
                vmlal_s16(vmull_s16(i_high, i_high), q_high, q_high)));
  }

  static uint16x8_t mean(uint16x8_t even, uint16x8_t odd) noexcept {
    return vcombine_u16(vrshrn_n_u32(vaddl_u16(vget_low_u16(even), vget_low_u16(odd)), 2),
                        vrshrn_n_u32(vaddl_u16(vget_high_u16(even), vget_high_u16(odd)), 2));
  }

  static uint16x8_t least_amp2(uint16x8_t offset, const Limits& limits) noexcept {
    const uint32x4_t ratio = vdupq_n_u32(limits.ratio);
    return upper(vmulq_u32(vmovl_u16(vget_low_u16(offset)), ratio),
                 vmulq_u32(vmovl_u16(vget_high_u16(offset)), ratio));
  }

  static uint16x8_t asymmetric(uint16x8_t uneven, uint16x8_t offset,
                               const Limits& limits) noexcept {
    return lower(above_noise(vget_low_u16(uneven), vget_low_u16(offset), limits),
                 above_noise(vget_high_u16(uneven), vget_high_u16(offset), limits));
  }

 private:
  static uint32x4_t nearest(uint32x4_t root, int32x4_t n) noexcept {
    const int32x4_t whole = vreinterpretq_s32_u32(root);
    const uint32x4_t up = vcgtq_s32(vmlsq_s32(n, whole, whole), whole);
    return vsubq_u32(root, up);
  }

  static uint32x4_t above_noise(uint16x4_t uneven, uint16x4_t offset,
                                const Limits& limits) noexcept {
    const uint32x4_t slope = vdupq_n_u32(limits.asymmetry_slope);
    const uint32x4_t shot = vshrq_n_u32(vmulq_u32(vmovl_u16(offset), slope), 8);
    const uint32x4_t noise = vqaddq_u32(vdupq_n_u32(limits.asymmetry_base), shot);
    return vcgtq_u32(vmull_u16(uneven, uneven), noise);
  }
};

}  // namespace stof::dsp::neon::phase_steps
