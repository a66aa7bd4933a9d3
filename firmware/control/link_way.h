#pragma once

#include <cstdint>

#include "hal/network_interfaces.h"

// Requests by broadcast, of hosts that have no address of the sensor's network: they come to
// 255.255.255.255 from port kLinkPort, and are answered at 255.255.255.255 and that port, by the
// same interface. No router passes such packets on, and no other port of anybody gets one. What is
// told so is told to the whole link: no stream goes this way, and a cookie that was given on it
// says only that somebody there has heard it.
namespace stof::firmware {

// Where all that a sensor tells to a whole link arrives.
inline constexpr std::uint16_t kLinkPort = 7561;

// A host that asks so: its IPv4 address, and the interface by which it is heard, which no other
// IPv4 peer has. So a cookie of one way is none of the other.
constexpr bool is_over_link(const hal::Peer& peer) noexcept {
  return peer.scope != 0 && hal::is_ipv4(peer.address);
}

// Whom answers reach.
constexpr hal::Peer all_of_link(std::uint32_t interface) noexcept {
  return {.address = hal::kAllOfLink, .port = kLinkPort, .scope = interface};
}

}  // namespace stof::firmware
