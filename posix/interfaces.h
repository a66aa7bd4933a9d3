#pragma once

#include <vector>

#include <netinet/in.h>

namespace stof::posix {

// Which ways lead to neighbours on the network.
struct Interfaces {
  std::vector<in_addr> broadcasts;
  std::vector<unsigned> multicast;  // indices
};
// Lists the interfaces that are up.
Interfaces list_interfaces();

}  // namespace stof::posix
