#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include <sys/socket.h>

#include "host/client/error.h"

namespace stof::client {

inline constexpr std::uint16_t kDefaultPort = 7560;

// A sockaddr of any family.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = 0;

  // The socket interface takes sockaddr*, whatever is behind it.
  sockaddr* generic() noexcept;
  std::uint16_t port() const noexcept;
  std::string text() const;  // "192.168.1.20:7560", "[fe80::1%eth0]:7560"
};

// Every address of "HOST[:PORT]", in the order to try them; at least one. HOST: a name or a number,
// an IPv6 address with a port in brackets; port kDefaultPort without. May block on a name server.
// kInvalidArgument: not such a text; kDeviceError: no such host.
std::expected<std::vector<SocketAddress>, OpenError> resolve_sensor(std::string_view sensor);

}  // namespace stof::client
