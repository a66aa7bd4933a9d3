#pragma once

#include "dsp/base/status.h"
#include "hal/time.h"

namespace stof::hal {

class Trigger {
 public:
  virtual ~Trigger() = default;
  // Drives one pulse on all camera lines and returns the time of its rising edge. Blocks no longer
  // than the pulse. kDeviceError: no edge, or an unknown one, went out; kDeviceLost: reopen.
  virtual Result<Time> pulse() noexcept = 0;
};

}  // namespace stof::hal
