#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "board/board.h"

// The command line of a board with real devices.
namespace stof::board {

struct PictureSize {
  int width = 0;
  int height = 0;
};

enum class PairKind : std::uint8_t { kV4l2, kLibcamera };

struct DeviceOptions {
  PairKind cameras = PairKind::kV4l2;
  std::string left;         // in place of the table's
  std::string right;        // as left; "none": both pictures come from the left one
  std::string pmd = "usb";  // "none", or a V4L2 node that sends stacked raw phases
  std::string left_strobe;  // a GPIO line in place of the table's; "none": not wired
  std::string right_strobe;
  std::optional<PictureSize> size;  // of one picture of the pair
  std::optional<PictureSize> pmd_size;
  std::optional<int> gain;
  std::string pair_button;      // a GPIO line in place of the table's; "none"
  std::string watchdog;         // in place of the table's; "none"
  std::optional<int> priority;  // in place of the table's
  bool uncalibrated = false;
};

std::expected<DeviceOptions, Refusal> parse_device_options(
    std::span<const std::string_view> arguments);

// The GPIO line of the button; empty: not wired.
std::string button_line(const DeviceOptions& options);

// The GPIO lines on which left and right camera tell when they expose; empty: not wired.
std::array<std::string, 2> strobe_lines(const DeviceOptions& options);

}  // namespace stof::board
