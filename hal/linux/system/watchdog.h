#pragma once

#include <expected>
#include <memory>
#include <string>

#include "hal/linux/open_error.h"
#include "hal/watchdog.h"

namespace stof::hal::linux {

struct WatchdogOptions {
  std::string device = "/dev/watchdog0";
  // Whole seconds, as the driver counts; it may take another time: see timeout().
  std::chrono::seconds timeout{10};
};

// A Linux watchdog device (Documentation/watchdog/watchdog-api.rst).
class WatchdogDevice final : public hal::Watchdog {
 public:
  // From here on it runs. An error is one line; nothing runs then.
  static std::expected<std::unique_ptr<WatchdogDevice>, OpenError> open(
      const WatchdogOptions& options);
  // Without disarm() before it, the machine restarts.
  ~WatchdogDevice() override;
  WatchdogDevice(const WatchdogDevice&) = delete;
  WatchdogDevice& operator=(const WatchdogDevice&) = delete;

  Status kick() noexcept override;
  Duration timeout() const noexcept override { return timeout_; }
  // Closes the device with the magic 'V'. kUnsupported: the driver does not know it. One
  // that was told never to stop (nowayout) runs on and says nothing. Kicks do nothing afterwards:
  // kDeviceError.
  Status disarm() noexcept override;

 private:
  WatchdogDevice(int fd, Duration timeout, bool can_stop) noexcept
      : fd_(fd), timeout_(timeout), can_stop_(can_stop) {}

  int fd_;  // -1: disarmed
  Duration timeout_;
  bool can_stop_;
};

}  // namespace stof::hal::linux
