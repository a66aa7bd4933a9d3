#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "dsp/base/simd.h"
#include "dsp/pmd/phase/phase_steps_neon.h"

// For phase_neon.cpp alone.
namespace stof::dsp::neon::phase_steps {

// Samples of up to 13 bits with limits of usual size: 16 bits hold everything.
struct Narrow {
  static constexpr std::uint16_t kMostSample = 8191;
  static constexpr int kMostStray = 3000;
  static constexpr std::uint32_t kMostSlope = 1023;
  static constexpr std::uint32_t kMostUneven = 255;
  static constexpr bool kMayBeAsymmetric = true;

  // Whether limits fit; the loop reports afterwards whether the samples did.
  static bool fits(const PhaseLimits& limits) noexcept {
    const std::uint64_t noise =
        std::uint64_t{limits.asymmetry_base} + ((limits.asymmetry_slope_q8 * kMostSample) >> 8U);
    const bool noise_fits =
        limits.asymmetry_slope_q8 <= kMostSlope && noise < kMostUneven * kMostUneven;
    return limits.saturation <= kMostSample + 1 && limits.ratio_q16 <= 65535 &&
           limits.ratio_q16 % 2 == 0 &&
           std::max(std::abs(limits.stray_i), std::abs(limits.stray_q)) <= kMostStray &&
           (noise_fits || never_asymmetric(limits));
  }

  static Samples limited(const Samples& a) noexcept { return a; }

  static int16x8_t less_stray(uint16x8_t a, uint16x8_t b, int16x8_t stray) noexcept {
    return vsubq_s16(vreinterpretq_s16_u16(vsubq_u16(a, b)), stray);
  }

  // The root is at most 15827, and n - root^2 at most twice that.
  static uint16x8_t magnitude(const Quads& mn, const Quads& mx, int16x8_t i, int16x8_t q) noexcept {
    const int16x8_t root = vreinterpretq_s16_u16(
        lower(root_estimate(mn.low, mx.low), root_estimate(mn.high, mx.high)));
    const int16x8_t rest = vmlsq_s16(vmlaq_s16(vmulq_s16(i, i), q, q), root, root);
    return vsubq_u16(vreinterpretq_u16_s16(root), vcgtq_s16(rest, root));
  }

  static uint16x8_t mean(uint16x8_t even, uint16x8_t odd) noexcept {
    return vrshrq_n_u16(vaddq_u16(even, odd), 2);
  }

  static uint16x8_t least_amp2(uint16x8_t offset, const Limits& limits) noexcept {
    const int16x8_t half = vdupq_n_s16(static_cast<std::int16_t>(limits.ratio / 2));
    return vreinterpretq_u16_s16(simd::product_above(vreinterpretq_s16_u16(offset), half));
  }

  static uint16x8_t asymmetric(uint16x8_t uneven, uint16x8_t offset,
                               const Limits& limits) noexcept {
    // (2 * 4 offset * 32 slope) >> 16 is slope * offset >> 8.
    const int16x8_t slope = vdupq_n_s16(static_cast<std::int16_t>(limits.asymmetry_slope << 5U));
    const int16x8_t shot =
        simd::product_above(vreinterpretq_s16_u16(vshlq_n_u16(offset, 2)), slope);
    const uint16x8_t noise =
        vaddq_u16(vreinterpretq_u16_s16(shot),
                  vdupq_n_u16(static_cast<std::uint16_t>(limits.asymmetry_base)));
    const uint16x8_t inside = vminq_u16(uneven, vdupq_n_u16(kMostUneven));
    return vcgtq_u16(vmulq_u16(inside, inside), noise);
  }
};

// The same where kPmdAsymmetric is never set.
struct NarrowStill : Narrow {
  static constexpr bool kMayBeAsymmetric = false;
};

}  // namespace stof::dsp::neon::phase_steps
