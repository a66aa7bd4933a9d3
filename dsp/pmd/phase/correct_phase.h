#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/calib/pmd_sensor.h"

namespace stof::dsp {

// One step of the wiggling table: W at its beginning and what W gains until the next step (the
// short way round). Both in 1/65536 turn.
struct WigglingStep {
  std::int16_t value = 0;
  std::int16_t gain = 0;
};
using WigglingSteps = std::array<WigglingStep, kWigglingSteps>;

inline constexpr std::uint16_t kPatternScaleOne = 1 << 14;

struct PhaseCorrection {
  bool phase_falls = false;
  Phase global = 0;  // subtracted from every pixel's phase, temperature included
  // The fixed pattern is stored in turns of the first frequency; in turns of the second the same
  // metres are f2 / f1 as much.
  std::uint16_t pattern_scale_q14 = kPatternScaleOne;
  WigglingSteps wiggling{};
};

// Measured phase to the phase that is proportional to distance, for one row:
//   phi1 = +-phase - ((fixed_pattern * pattern_scale_q14 + 2^13) >> 14) - global
//   corrected = phi1 - W(phi1), W linear between the steps
// Every sum wraps and is never clipped. fixed_pattern is empty or as long as the others. Equal
// lengths, any length, any alignment; no overlap.
using CorrectPhaseKernel = void(std::span<const Phase> phase,
                                std::span<const std::int16_t> fixed_pattern,
                                const PhaseCorrection& correction,
                                std::span<Phase> corrected) noexcept;
STOF_KERNEL(CorrectPhaseKernel, correct_phase, kNeon)

}  // namespace stof::dsp
