#include "posix/socket_address.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <memory>
#include <system_error>

#include <netdb.h>

namespace stof::posix {
namespace {

template <typename Address>
SocketAddress stored(const Address& address) noexcept {
  SocketAddress out;
  std::memcpy(&out.storage, &address, sizeof address);
  out.length = sizeof address;
  return out;
}

}  // namespace

sockaddr* SocketAddress::generic() noexcept {
  return reinterpret_cast<sockaddr*>(&storage);  // NOLINT: the sockets' own interface
}

const sockaddr* SocketAddress::generic() const noexcept {
  return reinterpret_cast<const sockaddr*>(&storage);  // NOLINT: the sockets' own interface
}

std::uint16_t SocketAddress::port() const noexcept {
  static_assert(offsetof(sockaddr_in, sin_port) == offsetof(sockaddr_in6, sin6_port));
  sockaddr_in any{};
  std::memcpy(&any, &storage, sizeof any);
  return ntohs(any.sin_port);
}

std::string SocketAddress::host() const {
  std::array<char, NI_MAXHOST> text{};
  const int failed = getnameinfo(generic(), length, text.data(),
                                 static_cast<socklen_t>(text.size()), nullptr, 0, NI_NUMERICHOST);
  return failed == 0 ? text.data() : "";
}

std::string SocketAddress::text() const {
  const std::string name = host();
  return (family() == AF_INET6 ? "[" + name + "]" : name) + ":" + std::to_string(port());
}

bool operator==(const SocketAddress& a, const SocketAddress& b) noexcept {
  return a.length == b.length && std::memcmp(&a.storage, &b.storage, a.length) == 0;
}

in6_addr map_ipv4(const in_addr& address) noexcept {
  in6_addr mapped{};
  std::uint8_t* const bytes = static_cast<std::uint8_t*>(mapped.s6_addr);
  bytes[10] = 0xFF;
  bytes[11] = 0xFF;
  std::memcpy(bytes + 12, &address, sizeof address);
  return mapped;
}

SocketAddress make_address(const in_addr& address, std::uint16_t port) noexcept {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(port);
  out.sin_addr = address;
  return stored(out);
}

SocketAddress make_address(const in6_addr& address, std::uint16_t port,
                           std::uint32_t scope) noexcept {
  sockaddr_in6 out{};
  out.sin6_family = AF_INET6;
  out.sin6_port = htons(port);
  out.sin6_addr = address;
  out.sin6_scope_id = scope;
  return stored(out);
}

std::optional<HostPort> split_host_port(std::string_view text, std::uint16_t default_port) {
  std::string_view host = text;
  std::string_view port;
  const std::size_t colon = text.rfind(':');
  if (text.starts_with('[')) {
    const std::size_t close = text.find(']');
    if (close == std::string_view::npos) {
      return std::nullopt;
    }
    host = text.substr(1, close - 1);
    port = text.substr(close + 1);
  } else if (colon != std::string_view::npos && text.find(':') == colon) {
    host = text.substr(0, colon);
    port = text.substr(colon);
  }
  HostPort out{.host = std::string(host), .port = default_port};
  if (!port.empty()) {
    const char* const end = port.data() + port.size();
    const auto [stop, error] = std::from_chars(port.data() + 1, end, out.port);
    if (!port.starts_with(':') || error != std::errc{} || stop != end) {
      return std::nullopt;
    }
  }
  return out.host.empty() || out.port == 0 ? std::nullopt : std::optional(std::move(out));
}

std::expected<std::vector<SocketAddress>, std::string> resolve(const HostPort& target,
                                                               Names names) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV | (names == Names::kLookUp ? 0 : AI_NUMERICHOST);
  addrinfo* found = nullptr;
  const int error =
      getaddrinfo(target.host.c_str(), std::to_string(target.port).c_str(), &hints, &found);
  if (error != 0) {
    return std::unexpected(std::string(gai_strerror(error)));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, freeaddrinfo);
  std::vector<SocketAddress> addresses;
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    SocketAddress& address = addresses.emplace_back();
    address.length = std::min<socklen_t>(entry->ai_addrlen, sizeof address.storage);
    std::memcpy(&address.storage, entry->ai_addr, address.length);
  }
  return addresses;
}

}  // namespace stof::posix
