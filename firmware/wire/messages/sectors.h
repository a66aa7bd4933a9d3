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

inline constexpr std::size_t kSectorReportBytes = 156;

// Type 69: the nearest obstacle in each of 72 directions, by its near bound.
struct SectorReport {
  std::int32_t first_udeg = 0;  // direction of the middle of the first sector, millionths of a
                                // degree, clockwise from straight ahead
  std::uint32_t step_udeg = 0;  // from one sector to the next
  std::uint16_t least_cm = 0;   // nearest distance that can be told
  std::uint16_t most_cm = 0;    // furthest
  std::array<std::uint16_t, 72>
      distances_cm{};  // horizontal distance from the camera, rounded towards it; 65535: unknown
};

void encode_sector_report(const SectorReport& value,
                          std::span<std::byte, kSectorReportBytes> out) noexcept;
// kCorrupt: shorter than kSectorReportBytes. What follows is of a newer sender and ignored.
Result<SectorReport> decode_sector_report(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
