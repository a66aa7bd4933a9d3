#pragma once

#include <array>
#include <string_view>

namespace stof::board {

// Names of serial lines that settings may name: they begin with one of these, and have no folder
// behind it. Not pseudo-terminals: somebody may sit there.
inline constexpr std::array<std::string_view, 6> kSerialLines{
    "/dev/ttyAMA", "/dev/ttyS",          "/dev/ttyUSB",
    "/dev/ttyACM", "/dev/serial/by-id/", "/dev/serial/by-path/"};

constexpr bool takes_serial_line(std::string_view device) noexcept {
  for (const std::string_view line : kSerialLines) {
    if (device.starts_with(line) && device.size() > line.size() &&
        device.find('/', line.size()) == std::string_view::npos) {
      return true;
    }
  }
  return device.empty();
}

}  // namespace stof::board
