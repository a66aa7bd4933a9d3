#pragma once

#include <expected>
#include <string_view>

#include "hal/link.h"
#include "hal/linux/open_error.h"

namespace stof::hal::posix {

// A connected, non-blocking UDP socket that never sends IP fragments.
// send(): kWouldBlock: the socket's buffer is full; kDeviceError: nobody listened to an earlier
// datagram (this one was sent nevertheless), or the network is down; kTooLarge: above kMaxDatagram
// or what the path carries; kDeviceLost: reopen.
class UdpLink final : public hal::Link {
 public:
  // destination: HOST:PORT, HOST numeric or a name, an IPv6 address in brackets: "[::1]:5600".
  // send_buffer: bytes asked of the kernel, which may give less. May block on a name server.
  static std::expected<UdpLink, OpenError> open(std::string_view destination,
                                                int send_buffer = 1 << 20);

  UdpLink(UdpLink&& other) noexcept;
  UdpLink& operator=(UdpLink&& other) noexcept;
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;
  ~UdpLink() override;

  Status send(std::span<const std::byte> datagram) noexcept override;

 private:
  explicit UdpLink(int fd) noexcept : fd_(fd) {}

  int fd_ = -1;
};

}  // namespace stof::hal::posix
