#include "dsp/pmd/interval/sigma.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

constexpr int kCurveBits = 10;

// Nearest integer, ties to even, for 0 <= v < 2^22.
int nearest_even(float v) noexcept { return static_cast<int>(v + 12582912.0F) - 12582912; }

// 1 .. 65535.
QuarterMm limited(float sigma) noexcept {
  return static_cast<QuarterMm>(nearest_even(std::clamp(sigma, 1.0F, 65535.0F)));
}

}  // namespace

void sigma_and_ratio(std::span<const std::uint16_t> amp2, std::span<const std::uint16_t> offset,
                     const NoiseModel& model, std::span<QuarterMm> sigma,
                     std::span<std::uint8_t> ratio) noexcept {
  const std::size_t n = sigma.size();
  STOF_CHECK(amp2.size() == n && offset.size() == n && ratio.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    const float variance = model.slope * static_cast<float>(offset[x]) + model.base;
    sigma[x] = limited(std::sqrt(variance) / static_cast<float>(std::max<int>(amp2[x], 1)));
    const float modulation =
        static_cast<float>(128 * amp2[x]) / static_cast<float>(std::max<int>(offset[x], 1));
    ratio[x] = static_cast<std::uint8_t>(nearest_even(std::min(modulation, 255.0F)));
  }
}

void curve_sigma(std::span<const QuarterMm> distance, const SigmaCurve& curve,
                 std::span<QuarterMm> sigma) noexcept {
  STOF_CHECK(distance.size() == sigma.size());
  for (std::size_t x = 0; x < sigma.size(); ++x) {
    const int d = distance[x];
    const SigmaStep& step = curve[static_cast<std::size_t>(d >> kCurveBits)];
    const int part = d & ((1 << kCurveBits) - 1);
    const int value = step.value + round_shift(step.gain * part, kCurveBits);
    sigma[x] = static_cast<QuarterMm>(d == kNoDepth ? 0 : std::max(value, 1));
  }
}

void combine_sigma(std::span<const QuarterMm> other, std::span<QuarterMm> sigma) noexcept {
  STOF_CHECK(other.size() == sigma.size());
  for (std::size_t x = 0; x < sigma.size(); ++x) {
    const float a = sigma[x];
    const float b = other[x];
    sigma[x] = limited(a * b / std::sqrt(a * a + b * b));
  }
}

}  // namespace stof::dsp::ref
