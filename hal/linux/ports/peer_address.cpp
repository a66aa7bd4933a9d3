#include "hal/linux/ports/peer_address.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <string>

#include <netinet/in.h>

#include "posix/udp_socket.h"

namespace stof::hal::linux {
namespace {

// ::ffff:a.b.c.d
constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

std::unexpected<OpenError> refuse(std::string_view destination, std::string_view why) {
  std::string message = "cannot send to '";
  message.append(destination).append("': ").append(why);
  return std::unexpected(OpenError{std::move(message)});
}

// A static program has no resolver: that of glibc is made of shared libraries of its own version.
#if defined(STOF_STATIC)
constexpr posix::Names kNames = posix::Names::kAddressesOnly;
#else
constexpr posix::Names kNames = posix::Names::kLookUp;
#endif

}  // namespace

std::expected<Peer, OpenError> resolve(std::string_view destination) {
  const auto target = posix::split_host_port(destination);
  if (!target) {
    return refuse(destination, "give HOST:PORT, such as 192.168.1.20:5600 or [::1]:5600");
  }
  const auto addresses = posix::resolve(*target, kNames);
  if (!addresses) {
    return refuse(destination,
                  addresses.error() + (kNames == posix::Names::kLookUp
                                           ? "; check the host's name or give its address"
                                           : "; give the host's address, not a name"));
  }
  for (const posix::SocketAddress& address : *addresses) {
    if (const std::optional<Peer> peer = to_peer(address)) {
      return *peer;
    }
  }
  return refuse(destination, "the name has no IP address; give an address");
}

std::optional<posix::SocketAddress> to_socket_address(const Peer& peer, int family) noexcept {
  if (family == AF_INET6) {
    in6_addr address{};
    std::memcpy(&address, peer.address.data(), peer.address.size());
    return posix::make_address(address, peer.port, peer.scope);
  }
  if (!std::ranges::equal(std::span(peer.address).first<kMapped.size()>(), kMapped)) {
    return std::nullopt;
  }
  in_addr address{};
  std::memcpy(&address, &peer.address[kMapped.size()], sizeof address);
  return posix::make_address(address, peer.port);
}

std::optional<Peer> to_peer(const posix::SocketAddress& address) noexcept {
  Peer peer{.port = address.port()};
  if (address.family() == AF_INET6) {
    sockaddr_in6 v6{};
    std::memcpy(&v6, &address.storage, sizeof v6);
    std::memcpy(peer.address.data(), &v6.sin6_addr, peer.address.size());
    peer.scope = v6.sin6_scope_id;
    return peer;
  }
  if (address.family() == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address.storage, sizeof v4);
    const in6_addr mapped = posix::map_ipv4(v4.sin_addr);
    std::memcpy(peer.address.data(), &mapped, peer.address.size());
    return peer;
  }
  return std::nullopt;
}

bool is_broadcast(const Peer& peer) noexcept {
  const auto address = to_socket_address(peer, AF_INET);
  return address && posix::UdpSocket(AF_INET).connect(*address) == EACCES;
}

}  // namespace stof::hal::linux
