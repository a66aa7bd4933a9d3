#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "firmware/settings/settings.h"

// Addresses and names of the network as settings have them.
namespace stof::settings {

// An IPv4 address in the order of its bytes' weight: 192.168.7.2 is 0xC0A80702.
struct InterfaceAddress {
  std::uint32_t address = 0;
  int prefix_bits = 0;  // 8 to 30

  std::uint32_t mask() const noexcept { return ~0U << (32 - prefix_bits); }
  // The address of an interface of the same network: neither the network's own nor its broadcast.
  bool has_host(std::uint32_t other) const noexcept;
};

// "192.168.7.2": four numbers of 0 to 255 without leading zeros, as every program reads them.
std::optional<std::uint32_t> parse_ipv4(std::string_view text) noexcept;
// "192.168.7.2/24", the address of a host: no multicast, loopback or reserved one.
std::optional<InterfaceAddress> parse_interface_address(std::string_view text) noexcept;
// A label of RFC 1123: 1 to 63 letters of a to z, digits and hyphens, no hyphen at either end.
bool is_hostname(std::string_view text) noexcept;

// What keeps settings of the network from being of use together, in one line; empty: nothing.
const char* problem(const NetworkSettings& network) noexcept;

}  // namespace stof::settings
