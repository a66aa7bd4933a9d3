#pragma once

#include <expected>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/linux/open_error.h"

struct gpiod_chip;

namespace stof::hal::linux {

struct CloseGpioChip {
  void operator()(gpiod_chip* chip) const noexcept;
};
using GpioChip = std::unique_ptr<gpiod_chip, CloseGpioChip>;

// A chip and where on it the lines are that were asked for, in their order.
struct GpioLines {
  GpioChip chip;
  std::vector<unsigned> offsets;
};

// The chip `path`, or where that is empty the first gpiochip of `devices` that has all `lines`
// (named as GpioTriggerOptions tells).
std::expected<GpioLines, OpenError> find_gpio_lines(const std::string& path,
                                                    const std::string& devices,
                                                    std::span<const std::string> lines);

}  // namespace stof::hal::linux
