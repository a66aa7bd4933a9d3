#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/status.h"
#include "dsp/calib/calibration.h"

namespace stof::wire {

inline constexpr std::size_t kCalibrationPacketBytes = 120;
inline constexpr std::uint32_t kDepthUnitUm = 250;  // of one LSB of depth and width

// What a receiver needs to make points of a depth map, once a second. Integers with these scales:
// lens and offset in 1/65536 px, lengths in nm, rotation in 2^-30.
struct CalibrationPacket {
  std::uint16_t image_width = 0;
  std::uint16_t image_height = 0;
  std::uint16_t pmd_width = 0;  // 0: no PMD camera
  std::uint16_t pmd_height = 0;
  std::int32_t fx = 0;  // of the rectified left camera, in which depth is Z
  std::int32_t fy = 0;
  std::int32_t cx = 0;
  std::int32_t cy = 0;
  std::int32_t doff = 0;
  std::uint32_t depth_unit_um = kDepthUnitUm;
  std::uint32_t max_range = 0;  // in depth units
  std::uint32_t modulation_hz = 0;
  std::int64_t baseline_nm = 0;
  std::int64_t period_ns = 0;              // of the trigger
  std::array<std::int32_t, 9> rotation{};  // row-major: X_stereo = R X_pmd + T
  std::array<std::int64_t, 3> translation_nm{};

  friend bool operator==(const CalibrationPacket&, const CalibrationPacket&) = default;
};

// From the calibration at start; floating point ends here. max_range in quarter millimetres.
// kTooLarge: a number does not fit its field (a lens above 32767 px, a length above 9e9 m, an image
// side above 65535).
Result<CalibrationPacket> make_calibration_packet(const dsp::Calibration& calibration,
                                                  dsp::QuarterMm max_range,
                                                  std::int64_t period_ns) noexcept;

void encode_calibration_packet(const CalibrationPacket& packet,
                               std::span<std::byte, kCalibrationPacketBytes> out) noexcept;

// kCorrupt: shorter than kCalibrationPacketBytes, or a focal length or depth unit that is not
// positive. What follows is of a newer sender and ignored.
Result<CalibrationPacket> decode_calibration_packet(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
