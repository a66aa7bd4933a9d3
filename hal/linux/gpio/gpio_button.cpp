#include "hal/linux/gpio/gpio_button.h"

#include <cerrno>
#include <cstring>
#include <span>

#include <gpiod.h>

#include "hal/linux/gpio/gpio_lines.h"

namespace stof::hal::linux {
namespace {

struct FreeButtonSettings {
  void operator()(gpiod_line_settings* settings) const noexcept {
    gpiod_line_settings_free(settings);
  }
};
struct FreeButtonConfig {
  void operator()(gpiod_line_config* config) const noexcept { gpiod_line_config_free(config); }
};
struct FreeButtonRequest {
  void operator()(gpiod_request_config* config) const noexcept {
    gpiod_request_config_free(config);
  }
};

}  // namespace

std::expected<std::unique_ptr<GpioButton>, OpenError> GpioButton::open(
    const GpioButtonOptions& options) {
  const std::expected<GpioLines, OpenError> found =
      find_gpio_lines({}, options.devices, std::span(&options.line, 1));
  if (!found) {
    return std::unexpected(found.error());
  }
  const std::unique_ptr<gpiod_line_settings, FreeButtonSettings> settings(
      gpiod_line_settings_new());
  const std::unique_ptr<gpiod_line_config, FreeButtonConfig> lines(gpiod_line_config_new());
  const std::unique_ptr<gpiod_request_config, FreeButtonRequest> config(gpiod_request_config_new());
  gpiod_line_request* request = nullptr;
  const unsigned offset = found->offsets.front();
  if (settings && lines && config) {
    gpiod_line_settings_set_active_low(settings.get(), options.active_low);
    gpiod_request_config_set_consumer(config.get(), "stofd pairing");
    const bool set =
        gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT) == 0 &&
        gpiod_line_settings_set_bias(settings.get(), options.active_low
                                                         ? GPIOD_LINE_BIAS_PULL_UP
                                                         : GPIOD_LINE_BIAS_PULL_DOWN) == 0 &&
        gpiod_line_config_add_line_settings(lines.get(), &offset, 1, settings.get()) == 0;
    request =
        set ? gpiod_chip_request_lines(found->chip.get(), config.get(), lines.get()) : nullptr;
  }
  if (request == nullptr) {
    return std::unexpected(OpenError{"GPIO line '" + options.line + "': " + std::strerror(errno) +
                                     "; gpioinfo tells who has it"});
  }
  return std::unique_ptr<GpioButton>(new GpioButton(request, offset));
}

GpioButton::~GpioButton() { gpiod_line_request_release(request_); }

Result<bool> GpioButton::pressed() noexcept {
  const gpiod_line_value value = gpiod_line_request_get_value(request_, offset_);
  if (value == GPIOD_LINE_VALUE_ERROR) {
    return fail(errno == ENODEV ? Status::kDeviceLost : Status::kDeviceError);
  }
  return value == GPIOD_LINE_VALUE_ACTIVE;
}

}  // namespace stof::hal::linux
