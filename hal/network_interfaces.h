#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/datagram_port.h"

namespace stof::hal {

// One address of an interface of this machine.
struct InterfaceAddress {
  std::uint32_t interface = 0;               // its index, as Peer::scope
  std::array<std::uint8_t, 16> address{};    // as Peer::address
  std::array<std::uint8_t, 16> broadcast{};  // as Peer::address; all 0: none
  std::uint8_t prefix_bits = 0;              // that all of its link share, of the 128
  bool multicast = false;                    // the interface carries it

  friend bool operator==(const InterfaceAddress&, const InterfaceAddress&) = default;
};

// ::ffff:a.b.c.d
constexpr bool is_ipv4(const std::array<std::uint8_t, 16>& address) noexcept {
  for (std::size_t i = 0; i < 12; ++i) {
    if (address[i] != (i < 10 ? 0x00 : 0xff)) {
      return false;
    }
  }
  return true;
}

// ::ffff:a.b.c.d
constexpr std::array<std::uint8_t, 16> from_ipv4(std::uint8_t a, std::uint8_t b, std::uint8_t c,
                                                 std::uint8_t d) noexcept {
  return {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, a, b, c, d};
}

// All hosts of the link that Peer::scope names, and never one beyond it.
inline constexpr std::array<std::uint8_t, 16> kAllOfLink = from_ipv4(255, 255, 255, 255);

// The network interfaces of this machine.
class NetworkInterfaces {
 public:
  virtual ~NetworkInterfaces() = default;
  // The addresses of the interfaces that are up, as many as fit; how many. Does not allocate and
  // waits for nobody but the system.
  virtual std::size_t addresses(std::span<InterfaceAddress> space) noexcept = 0;
};

// A port that receives what is sent to the group of its purpose. Peers carry the interface that a
// datagram came by, or goes out by, in `scope`, also those of IPv4.
class MulticastPort : public DatagramPort {
 public:
  // Listens to the group at these interfaces from now on, too. Those that it listens at already, or
  // that cannot, cost nothing: call it again when the network has changed. Does not allocate.
  virtual void join(std::span<const InterfaceAddress> addresses) noexcept = 0;
};

}  // namespace stof::hal
