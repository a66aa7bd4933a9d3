#pragma once

#include <expected>
#include <memory>
#include <string>

#include "hal/button.h"
#include "hal/linux/open_error.h"

struct gpiod_line_request;

namespace stof::hal::linux {

struct GpioButtonOptions {
  std::string line;              // as in GpioTriggerOptions
  std::string devices = "/dev";  // where chips are looked for
  bool active_low = true;        // it connects the line with ground; the chip pulls it up
};

// A push button on a GPIO line. pressed() allocates nothing.
class GpioButton final : public hal::Button {
 public:
  static std::expected<std::unique_ptr<GpioButton>, OpenError> open(
      const GpioButtonOptions& options);
  ~GpioButton() override;
  GpioButton(const GpioButton&) = delete;
  GpioButton& operator=(const GpioButton&) = delete;

  Result<bool> pressed() noexcept override;

 private:
  GpioButton(gpiod_line_request* request, unsigned offset) noexcept
      : request_(request), offset_(offset) {}

  gpiod_line_request* request_;
  unsigned offset_;
};

}  // namespace stof::hal::linux
