#include "posix/udp_socket.h"

#include <array>
#include <cerrno>
#include <cstring>

namespace stof::posix {
namespace {

int error_of(int result) noexcept { return result < 0 ? errno : 0; }

}  // namespace

UdpSocket::UdpSocket(int family) noexcept
    : fd_(socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {}

int UdpSocket::set(const SocketOption& option) const noexcept {
  return error_of(setsockopt(fd(), option.level, option.name, &option.value, sizeof option.value));
}

int UdpSocket::set(std::span<const SocketOption> options) const noexcept {
  for (const SocketOption& option : options) {
    if (const int error = set(option); error != 0) {
      return error;
    }
  }
  return 0;
}

int UdpSocket::set_buffer(Buffer which, int bytes) const noexcept {
  const bool sends = which == Buffer::kSend;
  const int option = sends ? SO_SNDBUF : SO_RCVBUF;
  static_cast<void>(set({SOL_SOCKET, option, bytes}));
  // Passes net.core.?mem_max and needs CAP_NET_ADMIN.
  static_cast<void>(set({SOL_SOCKET, sends ? SO_SNDBUFFORCE : SO_RCVBUFFORCE, bytes}));
  int granted = 0;
  socklen_t length = sizeof granted;
  static_cast<void>(getsockopt(fd(), SOL_SOCKET, option, &granted, &length));
  return granted / 2;  // the system doubles what is set, for its own bookkeeping
}

int UdpSocket::count_drops() const noexcept { return set({SOL_SOCKET, SO_RXQ_OVFL, 1}); }

int UdpSocket::stamp_arrivals() const noexcept { return set({SOL_SOCKET, SO_TIMESTAMPNS, 1}); }

int UdpSocket::tell_own_address(int family) const noexcept {
  const int error = set({IPPROTO_IP, IP_PKTINFO, 1});
  return error == 0 && family == AF_INET6 ? set({IPPROTO_IPV6, IPV6_RECVPKTINFO, 1}) : error;
}

int UdpSocket::bind(const SocketAddress& at) const noexcept {
  return error_of(::bind(fd(), at.generic(), at.length));
}

int UdpSocket::connect(const SocketAddress& to) const noexcept {
  return error_of(::connect(fd(), to.generic(), to.length));
}

std::uint16_t UdpSocket::port() const noexcept {
  SocketAddress address;
  return getsockname(fd(), address.generic(), &address.length) == 0 ? address.port() : 0;
}

int UdpSocket::send(std::span<const std::byte> datagram) const noexcept {
  return ::send(fd(), datagram.data(), datagram.size(), MSG_NOSIGNAL) < 0 ? errno : 0;
}

int UdpSocket::send_to(const SocketAddress& to,
                       std::span<const std::byte> datagram) const noexcept {
  const ssize_t sent =
      sendto(fd(), datagram.data(), datagram.size(), MSG_NOSIGNAL, to.generic(), to.length);
  return sent < 0 ? errno : 0;
}

int UdpSocket::send_by(unsigned interface, const SocketAddress& to,
                       std::span<const std::byte> datagram) const noexcept {
  SocketAddress address = to;
  iovec bytes{.iov_base = const_cast<std::byte*>(datagram.data()),  // NOLINT: only read
              .iov_len = datagram.size()};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(in_pktinfo))> control{};
  msghdr message{};
  message.msg_name = address.generic();
  message.msg_namelen = address.length;
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr& entry = *CMSG_FIRSTHDR(&message);
  entry.cmsg_level = IPPROTO_IP;
  entry.cmsg_type = IP_PKTINFO;
  entry.cmsg_len = CMSG_LEN(sizeof(in_pktinfo));
  in_pktinfo info{};
  info.ipi_ifindex = static_cast<int>(interface);
  std::memcpy(CMSG_DATA(&entry), &info, sizeof info);
  return sendmsg(fd(), &message, MSG_NOSIGNAL) < 0 ? errno : 0;
}

std::expected<std::size_t, int> UdpSocket::receive(std::span<std::byte> space,
                                                   SocketAddress* from) const noexcept {
  if (from != nullptr) {
    *from = {};
  }
  const ssize_t got =
      recvfrom(fd(), space.data(), space.size(), 0, from == nullptr ? nullptr : from->generic(),
               from == nullptr ? nullptr : &from->length);
  if (got < 0) {
    return std::unexpected(errno);
  }
  return static_cast<std::size_t>(got);
}

bool answers_earlier(int error) noexcept {
  return error == ECONNREFUSED || error == EHOSTUNREACH || error == ENETUNREACH ||
         error == EPROTO || error == ENOPROTOOPT || error == EACCES || error == EMSGSIZE;
}

}  // namespace stof::posix
