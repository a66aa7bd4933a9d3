#pragma once

#include "hal/clock.h"

// Devices of a Linux machine. Sources are compiled as standard C++: with GNU extensions `linux`
// would be a macro.
namespace stof::hal::linux {

// CLOCK_MONOTONIC. Waits sleep; any thread may use it.
class Clock final : public hal::Clock {
 public:
  Time now() noexcept override;
  void wait_until(Time time) noexcept override;
};

}  // namespace stof::hal::linux
