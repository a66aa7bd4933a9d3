#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Limits of usable samples of a PMD pixel, in LSB of a sample.
struct PhaseLimits {
  std::uint16_t saturation = 4095;  // a sample at or above it: kPmdSaturated
  std::uint16_t lowest = 1;         // a sample below it: kPmdUnderRange; 0 = never
  std::uint16_t dark = 0;           // subtracted from the mean, clamped at 0
  std::uint16_t min_amp2 = 8;       // amp2 below it: kPmdLowAmplitude
  // amp2 < (ratio_q16 * offset) >> 16: kPmdLowRatio. 2 * ratio * 65536, at most 131072; even
  // numbers below 65536 are faster.
  std::uint32_t ratio_q16 = 39322;
  // (A0 + A2 - A1 - A3)^2 > base + ((slope_q8 * offset) >> 8): kPmdAsymmetric. The even sums are
  // equal on a static scene whatever the phase and its odd harmonics (wiggling), so this is a
  // number of noise variances. slope_q8 at most 131072.
  std::uint32_t asymmetry_base = 0xFFFFFFFF;
  std::uint32_t asymmetry_slope_q8 = 0;
  // Stray light inside the camera adds these to I and Q; they are subtracted. -32767 .. 32767.
  std::int16_t stray_i = 0;
  std::int16_t stray_q = 0;
};
inline constexpr std::uint32_t kMaxRatioQ16 = 131072;
inline constexpr std::uint32_t kMaxAsymmetrySlopeQ8 = 131072;

// A0 .. A3, one row each; 10 to 15 bits used, larger values count as 32767.
using SampleRows = std::array<std::span<const std::uint16_t>, 4>;

struct PhaseRow {
  std::span<Phase> phase;
  std::span<std::uint16_t> amp2;
  std::span<std::uint16_t> offset;
  std::span<std::uint8_t> flags;
};

// For each pixel, with I = A0 - A2 - stray_i and Q = A3 - A1 - stray_q, both limited to +-32767:
//   phase  = atan2(Q, I), one turn is 65536; at most 0.70 from the real number; 0 when I = Q = 0
//   amp2   = sqrt(I^2 + Q^2) rounded to nearest, exactly; at most 46340
//   offset = (A0 + A1 + A2 + A3 + 2) / 4 - dark, at least 0
//   flags  = kPmdSaturated, kPmdUnderRange, kPmdLowAmplitude, kPmdLowRatio, kPmdAsymmetric
// How phase is computed (both variants, bit for bit): t = mn / mx in Q16 by one IEEE single
// division, theta = t + t P(t^2) in 1/8 phase units, P of degree 5 fitted with this very rounding,
// then octants are folded. Equal lengths, any length, any alignment; no overlap.
using PhaseKernel = void(const SampleRows& samples, const PhaseLimits& limits,
                         const PhaseRow& out) noexcept;

// (4 / pi) atan(t) - t = t P(t^2) on 0 <= t <= 1: coefficients of P in Q16, lowest first, found by
// search over integers around the minimax polynomial; the largest error over all t is 0.699.
inline constexpr std::array<std::int16_t, 6> kArcTangentQ16{17907,  -27784, 16297,
                                                            -10050, 4729,   -1100};

STOF_KERNEL(PhaseKernel, phase, kAvx2)

}  // namespace stof::dsp
