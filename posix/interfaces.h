#pragma once

#include <optional>
#include <string>
#include <vector>

#include <netinet/in.h>

#include "posix/socket_address.h"

namespace stof::posix {

// One line of the system's list: an interface has one for each of its addresses, and one without.
struct InterfaceEntry {
  std::string name;                        // of the interface: "eth0"
  unsigned index = 0;                      // of the interface
  unsigned flags = 0;                      // IFF_UP, IFF_LOOPBACK, ... of <net/if.h>
  std::optional<SocketAddress> address{};  // IPv4 or IPv6
  std::optional<in_addr> broadcast{};      // of an IPv4 address that has one
};
// Empty where the system does not tell.
std::vector<InterfaceEntry> interface_entries();

// Which ways lead to neighbours on the network.
struct Interfaces {
  std::vector<in_addr> broadcasts;
  std::vector<unsigned> multicast;  // indices
  std::vector<unsigned> links;      // indices of those that carry IPv4 broadcasts to other hosts
};
// Lists the interfaces that are up.
Interfaces list_interfaces();

// Whether an interface of this machine has it.
bool is_own_address(const in_addr& address);

}  // namespace stof::posix
