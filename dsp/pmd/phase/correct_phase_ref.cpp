#include "dsp/pmd/phase/correct_phase.h"

#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

constexpr int kStepBits = 9;  // 65536 / 128 phase units a step
constexpr int kPatternBits = 14;

Phase corrected_of(Phase phase, std::int16_t fixed, const PhaseCorrection& correction) noexcept {
  const int sign = correction.phase_falls ? -1 : 1;
  const int pattern = round_shift(fixed * correction.pattern_scale_q14, kPatternBits);
  const Phase phi = static_cast<Phase>(sign * phase - pattern - correction.global);
  const WigglingStep step = correction.wiggling[static_cast<std::size_t>(phi >> kStepBits)];
  const int part = phi & ((1 << kStepBits) - 1);
  const int wiggle = step.value + round_shift(step.gain * part, kStepBits);
  return static_cast<Phase>(phi - wiggle);
}

}  // namespace

void correct_phase(std::span<const Phase> phase, std::span<const std::int16_t> fixed_pattern,
                   const PhaseCorrection& correction, std::span<Phase> corrected) noexcept {
  const std::size_t n = phase.size();
  STOF_CHECK(corrected.size() == n && (fixed_pattern.empty() || fixed_pattern.size() == n));
  for (std::size_t x = 0; x < n; ++x) {
    const std::int16_t fixed = fixed_pattern.empty() ? std::int16_t{0} : fixed_pattern[x];
    corrected[x] = corrected_of(phase[x], fixed, correction);
  }
}

}  // namespace stof::dsp::ref
