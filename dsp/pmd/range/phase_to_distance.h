#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Distances while they are computed: u32, quarter mm or 0.1 mm, below kMostUnits. Rows of them are
// changed in place from step to step: phase_to_distance (or combine_frequencies), correct_distance,
// emitter_offset, to_quarter_mm.
inline constexpr std::uint32_t kMostUnits = 1U << 28U;

// distance = (phase * turn + 32768) >> 16: one turn of corrected phase is `turn` units, at most
// kMostUnits. Equal lengths, any length, any alignment; no overlap.
using PhaseToDistance = void(std::span<const Phase> phase, std::uint32_t turn,
                             std::span<std::uint32_t> distance) noexcept;

// z = scale d + shift (Kuhnert & Stommel 2006, eq. 14), in place:
//   z = ((min(d, kMostUnits) * scale_q15 + 2^14) >> 15) + shift
// A z of 0 or less is a reading from one turn further away: `turn` is added once; what is still
// not positive becomes 1. At most kMostUnits. Any length, any alignment.
struct LinearDistanceCorrection {
  std::uint32_t scale_q15 = kPlainScale;  // at most kMostScale
  std::int32_t shift = 0;                 // within +-kMostUnits
  std::uint32_t turn = 0;                 // at most kMostUnits
  static constexpr std::uint32_t kPlainScale = 1U << 15U;
  static constexpr std::uint32_t kMostScale = 1U << 17U;
};
constexpr bool changes_nothing(const LinearDistanceCorrection& line) noexcept {
  return line.scale_q15 == LinearDistanceCorrection::kPlainScale && line.shift == 0;
}
constexpr bool usable(const LinearDistanceCorrection& line) noexcept {
  constexpr std::int32_t kMost = kMostUnits;
  return line.scale_q15 <= LinearDistanceCorrection::kMostScale && line.shift >= -kMost &&
         line.shift <= kMost && line.turn <= kMostUnits;
}
using CorrectDistance = void(const LinearDistanceCorrection& line,
                             std::span<std::uint32_t> distance) noexcept;

STOF_KERNEL(PhaseToDistance, phase_to_distance, kNeon)
STOF_KERNEL(CorrectDistance, correct_distance, kNeon)

}  // namespace stof::dsp
