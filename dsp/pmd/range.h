#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/target.h"
#include "dsp/calib/calibration.h"

namespace stof::dsp {

// One step of the wiggling table: W at its beginning and what W gains until the next step (the
// short way round). Both in 1/65536 turn.
struct WigglingStep {
  std::int16_t value = 0;
  std::int16_t gain = 0;
};
using WigglingSteps = std::array<WigglingStep, kWigglingSteps>;

struct RangeParams {
  bool phase_falls = false;
  Phase global = 0;         // subtracted from every pixel's phase; wraps
  std::uint16_t range = 1;  // K: quarter mm a turn, the unambiguous range
  // sigma = sqrt(noise_slope * offset + noise_base) / amp2, quarter mm: shot and fixed noise,
  // noise_slope = K_s^2 / g, noise_base = K_s^2 (suppressed / g + n^2).
  float noise_slope = 0;
  float noise_base = 0;
  WigglingSteps wiggling{};
};

// Phase to radial distance with its standard deviation, for one row:
//   phi1 = +-phase - fixed_pattern - global, wrapping; phi2 = phi1 - W(phi1), W linear between the
//   steps; distance = (phi2 * K + 32768) >> 16, quarter mm. A measured 0 is written as 1, because 0
//   means none; that a reading near 0 may be one near the whole range is the interval's business.
//   sigma = nearest integer (ties to even) of the formula above by IEEE single operations in that
//   order, 1 .. 65535.
// Where flags has a bit of kPmdMissing both are 0. fixed_pattern is empty or as long as the others.
// Equal lengths, any length, any alignment; no overlap.
using RangeKernel = void(std::span<const Phase> phase, std::span<const std::uint16_t> amp2,
                         std::span<const std::uint16_t> offset, std::span<const std::uint8_t> flags,
                         std::span<const std::int16_t> fixed_pattern, const RangeParams& params,
                         std::span<QuarterMm> distance, std::span<QuarterMm> sigma) noexcept;
namespace ref {
RangeKernel range;
}
namespace neon {
RangeKernel range;
}

}  // namespace stof::dsp
