#pragma once

#include <cstdint>

#include "firmware/serial/sector_finder.h"
#include "firmware/settings/settings.h"

namespace stof::firmware {

// The settings that a serial line needs.
struct SerialParams {
  settings::SerialMode mode = settings::SerialMode::kOff;
  settings::SerialProfile profile = settings::SerialProfile::kSectors;
  std::uint32_t baud = 921'600;
  std::uint32_t rate_hz = 10;  // at most; 1 or more
  bool width = false;          // the stream `width` beside depth
  SectorParams sectors{};
  std::uint8_t system_id = 1;
  std::uint8_t component_id = 196;

  friend bool operator==(const SerialParams&, const SerialParams&) = default;
};

// settings: valid.
constexpr SerialParams serial_params(const settings::Settings& settings) noexcept {
  return {.mode = settings.serial.mode,
          .profile = settings.serial.profile,
          .baud = static_cast<std::uint32_t>(settings.serial.baud),
          .rate_hz = static_cast<std::uint32_t>(settings.serial.rate_hz),
          .width = settings.serial.width,
          .sectors = {.obstacle = settings.sectors, .most_mm = settings.depth.max_range_mm},
          .system_id = static_cast<std::uint8_t>(settings.mavlink.system_id),
          .component_id = static_cast<std::uint8_t>(settings.mavlink.component_id)};
}

}  // namespace stof::firmware
