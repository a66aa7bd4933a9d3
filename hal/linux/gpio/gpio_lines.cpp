#include "hal/linux/gpio/gpio_lines.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string_view>

#include <dirent.h>
#include <gpiod.h>

#include "dsp/base/parse_number.h"

namespace stof::hal::linux {
namespace {

std::string why_not(const std::string& path, int error) {
  const char* advice = "give the name of a GPIO chip, such as /dev/gpiochip0";
  if (error == EACCES || error == EPERM) {
    advice = "add the user to the group of that device, often gpio";
  }
  return "GPIO chip '" + path + "': " + std::strerror(error) + "; " + advice;
}

// "LABEL:OFFSET" on this chip.
std::optional<unsigned> by_offset(gpiod_chip* chip, std::string_view line) {
  const std::size_t colon = line.rfind(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  const std::optional<unsigned> offset = dsp::parse_number<unsigned>(line.substr(colon + 1));
  gpiod_chip_info* const info = gpiod_chip_get_info(chip);
  if (info == nullptr) {
    return std::nullopt;
  }
  const std::string_view label = line.substr(0, colon);
  const bool here =
      offset && *offset < gpiod_chip_info_get_num_lines(info) &&
      (label == gpiod_chip_info_get_label(info) || label == gpiod_chip_info_get_name(info));
  gpiod_chip_info_free(info);
  return here ? offset : std::nullopt;
}

std::optional<unsigned> offset_of(gpiod_chip* chip, const std::string& line) {
  const int offset = gpiod_chip_get_line_offset_from_name(chip, line.c_str());
  return offset >= 0 ? std::optional(static_cast<unsigned>(offset)) : by_offset(chip, line);
}

// The offsets, or the first line that this chip has not.
std::expected<std::vector<unsigned>, std::string> offsets_on(gpiod_chip* chip,
                                                             std::span<const std::string> lines) {
  std::vector<unsigned> offsets;
  for (const std::string& line : lines) {
    const std::optional<unsigned> offset = offset_of(chip, line);
    if (!offset) {
      return std::unexpected(line);
    }
    offsets.push_back(*offset);
  }
  return offsets;
}

std::vector<std::string> chips_in(const std::string& folder) {
  std::vector<std::string> paths;
  DIR* const open = opendir(folder.c_str());
  if (open == nullptr) {
    return paths;
  }
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread has this folder
  while (const dirent* const entry = readdir(open)) {
    const std::string name = &entry->d_name[0];
    if (name.starts_with("gpiochip")) {
      paths.push_back(folder);
      paths.back().append("/").append(name);
    }
  }
  closedir(open);
  std::ranges::sort(paths);
  return paths;
}

}  // namespace

void CloseGpioChip::operator()(gpiod_chip* chip) const noexcept { gpiod_chip_close(chip); }

std::expected<GpioLines, OpenError> find_gpio_lines(const std::string& path,
                                                    const std::string& devices,
                                                    std::span<const std::string> lines) {
  const std::vector<std::string> paths =
      path.empty() ? chips_in(devices) : std::vector<std::string>{path};
  std::string trouble = "no GPIO chip in " + devices + "; load the driver of the board's GPIO";
  for (const std::string& candidate : paths) {
    GpioChip chip(gpiod_chip_open(candidate.c_str()));
    if (!chip) {
      trouble = why_not(candidate, errno);
      continue;
    }
    std::expected<std::vector<unsigned>, std::string> offsets = offsets_on(chip.get(), lines);
    if (offsets) {
      return GpioLines{.chip = std::move(chip), .offsets = std::move(*offsets)};
    }
    trouble = "GPIO line '" + offsets.error() + "': not on ";
    trouble += paths.size() == 1 ? candidate : "a chip that has the others";
    trouble += "; gpioinfo lists what there is";
  }
  return std::unexpected(OpenError{trouble});
}

}  // namespace stof::hal::linux
