// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "firmware/wire/messages/enums.h"
#include "firmware/wire/messages/structs.h"

namespace stof::wire {

inline constexpr std::size_t kCalibrationPacketBytes = 120;

// Type 64, with the first frame and then once a second.
struct CalibrationPacket {
  std::uint16_t image_width = 0;   // pixels
  std::uint16_t image_height = 0;  // rows
  std::uint16_t pmd_width = 0;     // pixels; 0: no PMD camera
  std::uint16_t pmd_height = 0;    // rows
  std::int32_t fx = 0;             // 1/65536 px, of the rectified left camera, in which depth is Z
  std::int32_t fy = 0;             // 1/65536 px
  std::int32_t cx = 0;             // 1/65536 px
  std::int32_t cy = 0;             // 1/65536 px
  std::int32_t doff = 0;           // 1/65536 px: cx of the right camera less that of the left
  std::uint32_t depth_unit_um = 250;             // of one step of depth and width, micrometres
  std::uint32_t max_range = 0;                   // maximal range, depth units
  std::uint32_t modulation_hz = 0;               // PMD modulation frequency, Hz
  std::int64_t baseline_nm = 0;                  // nm
  std::int64_t period_ns = 0;                    // of the trigger, ns
  std::array<std::int32_t, 9> rotation{};        // R, row by row, 2^-30
  std::array<std::int64_t, 3> translation_nm{};  // T, nm

  friend bool operator==(const CalibrationPacket&, const CalibrationPacket&) = default;
};

void encode_calibration_packet(const CalibrationPacket& value,
                               std::span<std::byte, kCalibrationPacketBytes> out) noexcept;
// kCorrupt: shorter than kCalibrationPacketBytes. What follows is of a newer sender and ignored.
Result<CalibrationPacket> decode_calibration_packet(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
