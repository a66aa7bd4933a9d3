#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/status.h"
#include "dsp/calib/calibration.h"
#include "firmware/wire/messages/calibration.h"

namespace stof::wire {

// From the calibration at start; floating point ends here. max_range in quarter millimetres.
// kTooLarge: a number does not fit its field (a lens above 32767 px, a length above 9e9 m, an image
// side above 65535).
Result<CalibrationPacket> make_calibration_packet(const dsp::Calibration& calibration,
                                                  dsp::QuarterMm max_range,
                                                  std::int64_t period_ns) noexcept;

// As decode_calibration_packet, and kCorrupt also where a focal length or the depth unit is not
// positive: what receivers divide by.
Result<CalibrationPacket> read_calibration_packet(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
