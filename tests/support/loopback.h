#pragma once

#include <cstdint>

#include <netinet/in.h>

#include "posix/socket_address.h"

namespace stof::test {

inline posix::SocketAddress loopback_address(std::uint16_t port) {
  return posix::make_address(in_addr{.s_addr = htonl(INADDR_LOOPBACK)}, port);
}

}  // namespace stof::test
