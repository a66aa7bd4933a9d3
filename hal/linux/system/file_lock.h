#pragma once

#include <chrono>
#include <string>

#include "dsp/base/status.h"

namespace stof::hal::linux {

// This program alone has a file or a block device from now on, until it ends, however it ends.
// Waits as long as `patience` for one that is just ending. make: makes it where it is missing, for
// its owner alone. kWouldBlock: another program has it; kUnsupported: it is neither a file nor a
// block device; kDeviceError: it cannot be opened, or its file system has no locks.
Status hold_file(const std::string& name, bool make, std::chrono::milliseconds patience);

}  // namespace stof::hal::linux
