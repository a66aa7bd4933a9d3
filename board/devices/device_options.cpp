#include "board/devices/device_options.h"

#include <utility>

#include "dsp/base/parse_number.h"

namespace stof::board {
namespace {

std::unexpected<Refusal> refuse(std::string message) {
  return std::unexpected(Refusal{std::move(message)});
}

std::optional<PictureSize> size(std::string_view text) {
  constexpr int kMost = 8192;
  const std::size_t x = text.find('x');
  if (x == std::string_view::npos) {
    return std::nullopt;
  }
  const std::optional<int> width = dsp::parse_number_in<int>(text.substr(0, x), 1, kMost);
  const std::optional<int> height = dsp::parse_number_in<int>(text.substr(x + 1), 1, kMost);
  return width && height ? std::optional(PictureSize{*width, *height}) : std::nullopt;
}

bool take_text(std::string_view flag, std::string_view value, DeviceOptions& options) {
  if (flag == "--left") {
    options.left = value;
  } else if (flag == "--right") {
    options.right = value;
  } else if (flag == "--pmd") {
    options.pmd = value;
  } else if (flag == "--left-strobe") {
    options.left_strobe = value;
  } else if (flag == "--right-strobe") {
    options.right_strobe = value;
  } else if (flag == "--pair-button") {
    options.pair_button = value;
  } else if (flag == "--watchdog") {
    options.watchdog = value;
  } else {
    return false;
  }
  return true;
}

// false: not one of these. What the flag takes: the value is none of that.
std::expected<bool, std::string> take_value(std::string_view flag, std::string_view value,
                                            DeviceOptions& options) {
  const char* takes = nullptr;
  if (flag == "--cameras") {
    options.cameras = value == "libcamera" ? PairKind::kLibcamera : PairKind::kV4l2;
    takes = value == "libcamera" || value == "v4l2" ? nullptr : "v4l2 or libcamera";
  } else if (flag == "--size") {
    options.size = size(value);
    takes = options.size ? nullptr : "WIDTHxHEIGHT, such as 640x480";
  } else if (flag == "--pmd-size") {
    options.pmd_size = size(value);
    takes = options.pmd_size ? nullptr : "WIDTHxHEIGHT, such as 176x144";
  } else if (flag == "--gain") {
    options.gain = dsp::parse_number_in<int>(value, 0, 65'535);
    takes = options.gain ? nullptr : "a whole number from 0 to 65535";
  } else if (flag == "--priority") {
    options.priority = dsp::parse_number_in<int>(value, 0, 98);
    takes = options.priority ? nullptr : "a whole number from 0 (none) to 98";
  } else {
    return take_text(flag, value, options);
  }
  if (takes != nullptr) {
    return std::unexpected(std::string(flag) + " takes " + takes + ", not \"" + std::string(value) +
                           "\"; try --help");
  }
  return true;
}

// Empty, or why the board has no room for pictures of that size.
std::string too_large(std::string_view flag, PictureSize asked, int width, int height) {
  if (asked.width <= width && asked.height <= height) {
    return {};
  }
  return std::string(flag) + ": board " + kConfig.name + " takes pictures of up to " +
         std::to_string(width) + "x" + std::to_string(height) + ": choose smaller ones";
}

std::string input_line(const std::string& wanted, const Net& net) {
  const std::string line = wanted.empty() ? std::string(net.line) : wanted;
  return line == "none" ? std::string() : line;
}

}  // namespace

std::expected<DeviceOptions, Refusal> parse_device_options(
    std::span<const std::string_view> arguments) {
  DeviceOptions options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view flag = arguments[i];
    if (flag == "--uncalibrated") {
      options.uncalibrated = true;
      continue;
    }
    const bool last = i + 1 == arguments.size();
    const std::string_view value = last ? std::string_view() : arguments[i + 1];
    const std::expected<bool, std::string> taken = take_value(flag, value, options);
    if (taken && !*taken) {
      return refuse("unknown argument \"" + std::string(flag) + "\"; try --help");
    }
    if (value.empty()) {
      return refuse(std::string(flag) + " takes a value; try --help");
    }
    if (!taken) {
      return refuse(taken.error());
    }
    ++i;
  }
  if (options.pmd == "none" && options.pmd_size) {
    return refuse("--pmd-size: there is no PMD camera with --pmd none: leave one out");
  }
  if (options.cameras == PairKind::kLibcamera &&
      !(options.left_strobe + options.right_strobe).empty()) {
    return refuse(
        "--left-strobe, --right-strobe: libcamera tells exposures itself: leave them out");
  }
  const PictureSize stereo = options.size.value_or(PictureSize{});
  const PictureSize pmd = options.pmd_size.value_or(PictureSize{});
  std::string why = too_large("--size", stereo, kConfig.stereo.width, kConfig.stereo.height);
  if (why.empty()) {
    why = too_large("--pmd-size", pmd, kConfig.pmd.width, kConfig.pmd.height);
  }
  if (!why.empty()) {
    return refuse(std::move(why));
  }
  return options;
}

std::string button_line(const DeviceOptions& options) {
  return input_line(options.pair_button, kConfig.devices.nets.pair_button);
}

std::array<std::string, 2> strobe_lines(const DeviceOptions& options) {
  const Nets& nets = kConfig.devices.nets;
  return {input_line(options.left_strobe, nets.left_strobe),
          input_line(options.right_strobe, nets.right_strobe)};
}

std::string_view usage() noexcept {
  return "  --cameras KIND       v4l2 (default), or libcamera where stofd was built with it\n"
         "  --left CAMERA        in place of the table's: /dev/video0, usb:VVVV:PPPP[:SERIAL], "
         "card:NAME\n"
         "                       or what libcamera calls it\n"
         "  --right CAMERA       likewise; none: both pictures come side by side from the left\n"
         "  --left-strobe LINE   GPIO line that is high while the camera exposes, in place of the "
         "table's,\n"
         "                       or none\n"
         "  --right-strobe LINE  likewise\n"
         "  --size WxH           of one picture (default: the table's)\n"
         "  --gain N             of both cameras, in their own units (default: as they are)\n"
         "  --pmd DEVICE         usb (default), a V4L2 device that sends four stacked raw phases, "
         "or none\n"
         "  --pmd-size WxH       of one of its phases\n"
         "  --uncalibrated       start without --calibration: pictures are right, depth is not "
         "measured\n"
         "  --watchdog DEVICE    in place of the table's, or none\n"
         "  --pair-button LINE   GPIO line of the button for pairing, in place of the table's, or "
         "none\n"
         "  --priority N         SCHED_FIFO of what computes, 0: none (default: the table's)\n";
}

}  // namespace stof::board
