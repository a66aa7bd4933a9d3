#include "hal/emu/devices/watchdog.h"

#include "dsp/base/check.h"

namespace stof::hal::emu {

Watchdog::Watchdog(hal::Clock& clock, Duration timeout) noexcept
    : clock_(clock), timeout_(timeout), last_(clock.now()) {
  STOF_CHECK(timeout > Duration::zero());
}

Status Watchdog::kick() noexcept {
  if (expired()) {
    return Status::kDeviceError;
  }
  ++kicks_;
  last_ = clock_.now();
  return Status::kOk;
}

Status Watchdog::disarm() noexcept {
  if (expired()) {
    return Status::kDeviceError;
  }
  armed_ = false;
  return Status::kOk;
}

bool Watchdog::expired() noexcept {
  expired_ = expired_ || (armed_ && clock_.now() - last_ > timeout_);
  return expired_;
}

}  // namespace stof::hal::emu
