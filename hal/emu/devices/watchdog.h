#pragma once

#include <cstdint>

#include "hal/clock.h"
#include "hal/watchdog.h"

namespace stof::hal::emu {

// Bites on the clock, and stays bitten: a test asks whether it has. The clock must outlive it.
class Watchdog final : public hal::Watchdog {
 public:
  // timeout > 0.
  Watchdog(hal::Clock& clock, Duration timeout) noexcept;

  // kDeviceError: too late.
  Status kick() noexcept override;
  Duration timeout() const noexcept override { return timeout_; }
  Status disarm() noexcept override;

  std::uint64_t kicks() const noexcept { return kicks_; }
  bool armed() const noexcept { return armed_; }
  // The machine has restarted by now.
  bool expired() noexcept;

 private:
  hal::Clock& clock_;
  Duration timeout_;
  Time last_;
  std::uint64_t kicks_ = 0;
  bool armed_ = true;
  bool expired_ = false;
};

}  // namespace stof::hal::emu
