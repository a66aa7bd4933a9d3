#include "host/discovery/discovery_socket.h"

#include <netinet/in.h>
#include <sys/socket.h>

namespace stof::client {
namespace {

posix::UdpSocket open_socket(int family, std::uint16_t port) {
  posix::UdpSocket socket(family);
  const bool ipv6 = family == AF_INET6;
  if (ipv6) {
    static_cast<void>(socket.set({IPPROTO_IPV6, IPV6_V6ONLY, 1}));
    static_cast<void>(socket.set({IPPROTO_IPV6, IPV6_MULTICAST_HOPS, 255}));
  } else {
    static_cast<void>(socket.set({SOL_SOCKET, SO_BROADCAST, 1}));
    static_cast<void>(socket.set({IPPROTO_IP, IP_MULTICAST_TTL, 255}));
    if (port != 0) {
      static_cast<void>(socket.set({IPPROTO_IP, IP_TTL, 1}));  // for neighbours alone
    }
  }
  static_cast<void>(socket.set({SOL_SOCKET, SO_REUSEADDR, port != 0 ? 1 : 0}));
  const posix::SocketAddress any =
      ipv6 ? posix::make_address(in6_addr{}, port) : posix::make_address(in_addr{}, port);
  return socket.bind(any) == 0 ? std::move(socket) : posix::UdpSocket();
}

}  // namespace

DiscoverySocket::DiscoverySocket(int family, std::uint16_t port)
    : family_(family), socket_(open_socket(family, port)) {}

void DiscoverySocket::send(const posix::SocketAddress& to,
                           std::span<const std::byte> datagram) const {
  if (is_open() && to.family() == family_) {
    static_cast<void>(socket_.send_to(to, datagram));
  }
}

void DiscoverySocket::send_by(unsigned interface, const posix::SocketAddress& to,
                              std::span<const std::byte> datagram) const {
  if (family_ == AF_INET6) {
    static_cast<void>(socket_.set({IPPROTO_IPV6, IPV6_MULTICAST_IF, static_cast<int>(interface)}));
    send(to, datagram);
  } else if (is_open()) {
    static_cast<void>(socket_.send_by(interface, to, datagram));
  }
}

std::optional<DiscoverySocket::Read> DiscoverySocket::receive(std::span<std::byte> space) const {
  posix::SocketAddress from;
  const auto got = socket_.receive(space, &from);
  if (!got) {
    return std::nullopt;
  }
  return Read{.datagram = space.first(*got), .from = from.host()};
}

}  // namespace stof::client
