#pragma once

#include <cstddef>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal {

// Where datagrams go.
class Link {
 public:
  virtual ~Link() = default;
  // Sends one datagram of at most 1,232 bytes, whole or not at all. Never blocks.
  // kWouldBlock: the queue is full, the datagram was dropped. kDeviceError: nobody can be reached
  // now. kDeviceLost: reopen.
  virtual Status send(std::span<const std::byte> datagram) noexcept = 0;
};

}  // namespace stof::hal
