#pragma once

#include <chrono>
#include <optional>

#include "hal/time.h"

namespace stof::firmware {

// Whether the sensor is in standby: nobody receives, so there are no edges and no light; devices
// stay open. Knows no clock: `now` is the caller's.
class Standby {
 public:
  // From the start, and from the last need on: whoever comes back soon finds it running.
  static constexpr hal::Duration kLinger = std::chrono::seconds(10);

  // Each round. enabled: the settings allow it. needed: somebody receives, or frames shall prove
  // something, or a device has to be watched.
  bool update(bool enabled, bool needed, hal::Time now) noexcept {
    if (needed || !enabled || !needed_at_) {
      needed_at_ = now;
    }
    active_ = now - *needed_at_ >= kLinger;
    return active_;
  }
  bool active() const noexcept { return active_; }

 private:
  std::optional<hal::Time> needed_at_;  // for the last time
  bool active_ = false;
};

}  // namespace stof::firmware
