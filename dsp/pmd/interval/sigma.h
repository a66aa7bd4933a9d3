#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Shot and fixed noise of one exposure: sigma = sqrt(slope * offset + base) / amp2, quarter mm,
// slope = K_s^2 / g, base = K_s^2 (suppressed light / g + n^2). Neither is negative.
struct NoiseModel {
  float slope = 0;
  float base = 0;
};

// What amplitude and light tell about a reading:
//   sigma = nearest integer (ties to even) of the formula above by IEEE single operations in that
//           order, 1 .. 65535; amp2 0 counts as 1
//   ratio = 128 amp2 / offset by one IEEE single division, rounded to nearest (ties to even), at
//           most 255: the modulation ratio A / offset in 1/256. Offset 0 counts as 1
// Equal lengths, any length, any alignment; no overlap.
using SigmaAndRatioKernel = void(std::span<const std::uint16_t> amp2,
                                 std::span<const std::uint16_t> offset, const NoiseModel& model,
                                 std::span<QuarterMm> sigma,
                                 std::span<std::uint8_t> ratio) noexcept;

// sigma by distance: steps of 1024 quarter mm (256 mm) and what sigma gains until the next,
// linear in between. A value 0 .. 65535, value + gain too.
struct SigmaStep {
  std::int32_t value = 0;
  std::int32_t gain = 0;
};
inline constexpr std::size_t kSigmaSteps = 64;
using SigmaCurve = std::array<SigmaStep, kSigmaSteps>;

// sigma = max(value + ((gain * (distance mod 1024) + 512) >> 10), 1), where distance is not 0; else
// 0. Equal lengths, any length, any alignment; no overlap.
using CurveSigmaKernel = void(std::span<const QuarterMm> distance, const SigmaCurve& curve,
                              std::span<QuarterMm> sigma) noexcept;

// Of the mean of two readings, each weighted by the inverse of its variance:
// sigma = sigma other / sqrt(sigma^2 + other^2) by IEEE single operations in that order, at least
// 1, in place. Neither is 0. Equal lengths, any length, any alignment; no overlap.
using CombineSigmaKernel = void(std::span<const QuarterMm> other,
                                std::span<QuarterMm> sigma) noexcept;

STOF_KERNEL(SigmaAndRatioKernel, sigma_and_ratio, kAvx2)
STOF_KERNEL(CurveSigmaKernel, curve_sigma, kNeon)
STOF_KERNEL(CombineSigmaKernel, combine_sigma, kAvx2)

}  // namespace stof::dsp
