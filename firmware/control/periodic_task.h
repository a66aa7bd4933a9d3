#pragma once

#include "hal/time.h"

namespace stof::firmware {

// A task of the control thread beside requests: beacon, mDNS, the serial line.
class PeriodicTask {
 public:
  virtual ~PeriodicTask() = default;
  // Called in turn, at least every 20 ms while the computer keeps up, sooner while requests come.
  // Does what is due, at most a millisecond of it; never blocks or allocates. `now`:
  // CLOCK_MONOTONIC, never goes back.
  virtual void tick(hal::Time now) noexcept = 0;
};

}  // namespace stof::firmware
