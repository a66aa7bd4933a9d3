#pragma once

#include "dsp/base/status.h"

namespace stof::hal::linux {

// Restarts the machine, for its administrator alone: what was written goes to its medium first.
// `command`: what the kernel hands to the firmware, such as "0 tryboot" of a Raspberry Pi's; empty:
// nothing. Returns where it is refused: kDeviceError.
Status restart_machine(const char* command) noexcept;

}  // namespace stof::hal::linux
