#pragma once

#include <cstddef>
#include <span>

#include "dsp/base/status.h"

namespace stof::hal {

// Fits an IPv6 packet of the smallest MTU, 1,280 bytes: never a fragment.
inline constexpr std::size_t kMaxDatagram = 1232;

// Where datagrams go.
class Link {
 public:
  virtual ~Link() = default;
  // Sends one datagram of at most kMaxDatagram bytes, whole or not at all. Never blocks.
  // kWouldBlock: the queue is full, the datagram was dropped. kDeviceError: nobody can be reached
  // now. kTooLarge: not taken. kDeviceLost: reopen.
  virtual Status send(std::span<const std::byte> datagram) noexcept = 0;
};

}  // namespace stof::hal
