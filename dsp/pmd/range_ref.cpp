#include "dsp/pmd/range.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp::ref {
namespace {

constexpr int kStepBits = 9;  // 65536 / 128 phase units a step

Phase corrected(Phase phase, std::int16_t fixed, const RangeParams& params) noexcept {
  const int sign = params.phase_falls ? -1 : 1;
  const Phase phi = static_cast<Phase>(sign * phase - fixed - params.global);
  const WigglingStep step = params.wiggling[static_cast<std::size_t>(phi >> kStepBits)];
  const int part = phi & ((1 << kStepBits) - 1);
  const int wiggle = step.value + round_shift(step.gain * part, kStepBits);
  return static_cast<Phase>(phi - wiggle);
}

QuarterMm distance_of(Phase phi, std::uint16_t range) noexcept {
  const std::uint64_t product = std::uint64_t{phi} * range;
  return static_cast<QuarterMm>(std::max<std::uint64_t>(round_shift(product, 16), 1));
}

QuarterMm sigma_of(std::uint16_t amp2, std::uint16_t offset, const RangeParams& params) noexcept {
  const float variance = params.noise_slope * static_cast<float>(offset) + params.noise_base;
  const float sigma = std::sqrt(variance) / static_cast<float>(std::max<int>(amp2, 1));
  const float limited = std::clamp(sigma, 1.0F, 65535.0F);
  return static_cast<QuarterMm>(static_cast<int>(limited + 12582912.0F) - 12582912);
}

}  // namespace

void range(std::span<const Phase> phase, std::span<const std::uint16_t> amp2,
           std::span<const std::uint16_t> offset, std::span<const std::uint8_t> flags,
           std::span<const std::int16_t> fixed_pattern, const RangeParams& params,
           std::span<QuarterMm> distance, std::span<QuarterMm> sigma) noexcept {
  const std::size_t n = phase.size();
  STOF_CHECK(amp2.size() == n && offset.size() == n && flags.size() == n);
  STOF_CHECK(distance.size() == n && sigma.size() == n);
  STOF_CHECK(fixed_pattern.empty() || fixed_pattern.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    if ((flags[x] & kPmdMissing) != 0) {
      distance[x] = kNoDepth;
      sigma[x] = 0;
      continue;
    }
    const std::int16_t fixed = fixed_pattern.empty() ? std::int16_t{0} : fixed_pattern[x];
    distance[x] = distance_of(corrected(phase[x], fixed, params), params.range);
    sigma[x] = sigma_of(amp2[x], offset[x], params);
  }
}

}  // namespace stof::dsp::ref
