#pragma once

#include <cstdint>

#include <netdb.h>
#include <netinet/in.h>

#include "posix/socket_address.h"

namespace stof::test {

inline posix::SocketAddress loopback_address(std::uint16_t port) {
  return posix::make_address(in_addr{.s_addr = htonl(INADDR_LOOPBACK)}, port);
}

// Whether this system knows the name "localhost". A bare chroot has no /etc/hosts.
inline bool knows_localhost() {
  addrinfo* found = nullptr;
  const bool known = getaddrinfo("localhost", nullptr, nullptr, &found) == 0;
  if (known) {
    freeaddrinfo(found);
  }
  return known;
}
inline constexpr const char* kNoLocalhost = "this system does not know the name localhost";

}  // namespace stof::test
