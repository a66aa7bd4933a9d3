#pragma once

#include "hal/time.h"

namespace stof::hal {

class Clock {
 public:
  virtual ~Clock() = default;
  // Never goes back. Does not block.
  virtual Time now() noexcept = 0;
  // Returns at or after `time`; at once when that has passed.
  virtual void wait_until(Time time) noexcept = 0;
};

}  // namespace stof::hal
