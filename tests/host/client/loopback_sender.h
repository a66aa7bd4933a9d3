#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "posix/udp_socket.h"
#include "tests/support/loopback.h"

namespace stof::test {

// Sends datagrams to a UDP port of this machine.
class LoopbackSender {
 public:
  explicit LoopbackSender(std::uint16_t port)
      : connected_(socket_.connect(loopback_address(port)) == 0) {}

  bool connected() const { return connected_; }

  Status send(std::span<const std::byte> datagram) noexcept {
    return socket_.send(datagram) == 0 ? Status::kOk : Status::kDeviceError;
  }

 private:
  posix::UdpSocket socket_{AF_INET};
  bool connected_;
};

}  // namespace stof::test
