#pragma once

#include "dsp/base/status.h"

namespace stof::hal {

// A push button that somebody at the device presses. For one thread; allocates nothing.
class Button {
 public:
  virtual ~Button() = default;
  // Whether it is held down now; its contacts may bounce. Does not block. kDeviceError: it cannot
  // be read now. kDeviceLost: it is gone.
  virtual Result<bool> pressed() noexcept = 0;
};

}  // namespace stof::hal
