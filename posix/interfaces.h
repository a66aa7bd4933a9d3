#pragma once

#include <vector>

#include <netinet/in.h>

namespace stof::posix {

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
