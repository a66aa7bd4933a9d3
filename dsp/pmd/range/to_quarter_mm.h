#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// The units of distances while they are computed, as quarter mm in Q30.
inline constexpr std::uint32_t kQuarterMmQ30 = 1U << 30U;
inline constexpr std::uint32_t kTenthMmQ30 = 429'496'730;  // 0.4

// Publishes a row of computed distances. Where flags has a bit of kPmdMissing all three are 0.
//   reading   at least 1 unit (0 means none), at most kMostUnits
//   distance  (reading * unit_q30 + 2^29) >> 30, at least 1; 0 and kPmdOutOfRange where that is
//             above 65535
//   sigma     stays, but is 0 where distance is 0
// Equal lengths, any length, any alignment; no overlap.
using ToQuarterMmKernel = void(std::span<std::uint32_t> reading, std::uint32_t unit_q30,
                               std::span<std::uint8_t> flags, std::span<QuarterMm> distance,
                               std::span<QuarterMm> sigma) noexcept;
STOF_KERNEL(ToQuarterMmKernel, to_quarter_mm, kNeon)

}  // namespace stof::dsp
