#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

namespace stof::posix {

// An address and a port of IPv4 or IPv6, as the socket calls take them.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t length = sizeof(sockaddr_storage);  // as much room has a call that writes it

  // The socket calls take sockaddr*, whatever is behind it.
  sockaddr* generic() noexcept;
  const sockaddr* generic() const noexcept;
  int family() const noexcept { return storage.ss_family; }  // AF_INET or AF_INET6
  std::uint16_t port() const noexcept;
  std::string host() const;  // numeric; empty: of another family
  std::string text() const;  // "192.168.1.20:7560", "[fe80::1%eth0]:7560"

  friend bool operator==(const SocketAddress& a, const SocketAddress& b) noexcept;
};

SocketAddress make_address(const in_addr& address, std::uint16_t port) noexcept;
// scope: the interface of a link-local address, else 0.
SocketAddress make_address(const in6_addr& address, std::uint16_t port,
                           std::uint32_t scope = 0) noexcept;

// ::ffff:a.b.c.d
in6_addr map_ipv4(const in_addr& address) noexcept;

struct HostPort {
  std::string host;
  std::uint16_t port = 0;
};

// "HOST:PORT", PORT 1 .. 65535, an IPv6 address in brackets; also "HOST" alone, with or without
// brackets, where default_port is not 0. None: another text.
std::optional<HostPort> split_host_port(std::string_view text, std::uint16_t default_port = 0);

enum class Names : std::uint8_t { kLookUp, kAddressesOnly };

// Every address of a host, in the order to try them; at least one. May block on a name server. The
// error is what the system says.
std::expected<std::vector<SocketAddress>, std::string> resolve(const HostPort& target, Names names);

}  // namespace stof::posix
