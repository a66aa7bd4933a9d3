#pragma once

#include "dsp/base/status.h"
#include "hal/time.h"

namespace stof::hal {

// Restarts the machine when nobody kicks it for a while. Runs from its opening on; when it goes out
// of scope without disarm() it runs on, and the machine restarts. For one thread.
class Watchdog {
 public:
  virtual ~Watchdog() = default;
  // All is well. Does not block or allocate. kDeviceError: it was not heard.
  virtual Status kick() noexcept = 0;
  // It bites when this has passed since the last kick.
  virtual Duration timeout() const noexcept = 0;
  // An orderly end: it does not bite any more. kUnsupported: it cannot be
  // stopped. kDeviceError: it has bitten, or was not heard.
  virtual Status disarm() noexcept = 0;
};

}  // namespace stof::hal
