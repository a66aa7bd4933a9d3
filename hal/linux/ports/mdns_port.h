#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <utility>

#include "hal/linux/open_error.h"
#include "hal/network_interfaces.h"
#include "posix/udp_socket.h"

namespace stof::hal::linux {

// Port 5353 and the groups 224.0.0.251 and ff02::fb of multicast DNS, shared with the other
// responders of this machine. For one thread.
class MdnsPort final : public hal::MulticastPort {
 public:
  static constexpr std::uint16_t kPort = 5353;

  // IPv4, and IPv6 where the system has it.
  static std::expected<std::unique_ptr<MdnsPort>, OpenError> open();

  Status send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override;
  Result<Received> receive(std::span<std::byte> space, Duration timeout) noexcept override;
  std::uint64_t overruns() const noexcept override { return 0; }             // not counted
  bool take_unreachable(Peer& /*peer*/) noexcept override { return false; }  // not looked for
  std::uint16_t port() const noexcept override { return kPort; }
  void join(std::span<const InterfaceAddress> addresses) noexcept override;

 private:
  MdnsPort(posix::UdpSocket ipv4, posix::UdpSocket ipv6) noexcept
      : ipv4_(std::move(ipv4)), ipv6_(std::move(ipv6)) {}

  posix::UdpSocket ipv4_;
  posix::UdpSocket ipv6_;  // not open: none
  bool ipv6_first_ = false;
};

}  // namespace stof::hal::linux
