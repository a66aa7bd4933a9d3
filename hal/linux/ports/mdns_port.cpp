#include "hal/linux/ports/mdns_port.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>

#include <netinet/in.h>
#include <sys/socket.h>

#include "hal/linux/ports/peer_address.h"
#include "posix/poll.h"

namespace stof::hal::linux {
namespace {

constexpr std::array<std::uint8_t, 4> kGroup4{224, 0, 0, 251};
constexpr std::array<std::uint8_t, 16> kGroup6{0xff, 0x02, 0, 0, 0, 0, 0, 0,
                                               0,    0,    0, 0, 0, 0, 0, 0xfb};
constexpr int kTtl = 255;  // RFC 6762 section 11

constexpr std::array kIpv4Options{
    posix::SocketOption{SOL_SOCKET, SO_REUSEADDR, 1},
    posix::SocketOption{SOL_SOCKET, SO_REUSEPORT, 1},
    posix::SocketOption{IPPROTO_IP, IP_PKTINFO, 1},
    posix::SocketOption{IPPROTO_IP, IP_MULTICAST_TTL, kTtl},
    posix::SocketOption{IPPROTO_IP, IP_TTL, kTtl},
    posix::SocketOption{IPPROTO_IP, IP_MULTICAST_LOOP, 1},
    posix::SocketOption{IPPROTO_IP, IP_MULTICAST_ALL, 0},
};
constexpr std::array kIpv6Options{
    posix::SocketOption{SOL_SOCKET, SO_REUSEADDR, 1},
    posix::SocketOption{SOL_SOCKET, SO_REUSEPORT, 1},
    posix::SocketOption{IPPROTO_IPV6, IPV6_V6ONLY, 1},
    posix::SocketOption{IPPROTO_IPV6, IPV6_RECVPKTINFO, 1},
    posix::SocketOption{IPPROTO_IPV6, IPV6_MULTICAST_HOPS, kTtl},
    posix::SocketOption{IPPROTO_IPV6, IPV6_UNICAST_HOPS, kTtl},
    posix::SocketOption{IPPROTO_IPV6, IPV6_MULTICAST_LOOP, 1},
};

// 0 or an errno.
int configure(const posix::UdpSocket& socket, std::span<const posix::SocketOption> options,
              const posix::SocketAddress& any) noexcept {
  const int error = socket.is_open() ? socket.set(options) : errno;
  return error == 0 ? socket.bind(any) : error;
}

// Room for the interface beside a datagram.
union Control {
  std::array<char, CMSG_SPACE(sizeof(in6_pktinfo))> bytes;
  cmsghdr alignment;
};

template <typename Info>
void write_control(msghdr& message, int level, int type, const Info& info) noexcept {
  message.msg_controllen = CMSG_SPACE(sizeof info);
  cmsghdr* const head = CMSG_FIRSTHDR(&message);
  head->cmsg_level = level;
  head->cmsg_type = type;
  head->cmsg_len = CMSG_LEN(sizeof info);
  std::memcpy(CMSG_DATA(head), &info, sizeof info);
}

std::uint32_t interface_of(msghdr& message) noexcept {
  for (cmsghdr* head = CMSG_FIRSTHDR(&message); head != nullptr;
       head = CMSG_NXTHDR(&message, head)) {
    if (head->cmsg_level == IPPROTO_IP && head->cmsg_type == IP_PKTINFO) {
      in_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(head), sizeof info);
      return static_cast<std::uint32_t>(info.ipi_ifindex);
    }
    if (head->cmsg_level == IPPROTO_IPV6 && head->cmsg_type == IPV6_PKTINFO) {
      in6_pktinfo info{};
      std::memcpy(&info, CMSG_DATA(head), sizeof info);
      return info.ipi6_ifindex;
    }
  }
  return 0;
}

Status send_one(int fd, const posix::SocketAddress& to, bool ipv6, std::uint32_t interface,
                std::span<const std::byte> datagram) noexcept {
  sockaddr_storage address = to.storage;
  // sendmsg() only reads what these point to.
  iovec vector{.iov_base = const_cast<std::byte*>(datagram.data()), .iov_len = datagram.size()};
  Control control{};
  msghdr message{};
  message.msg_name = &address;
  message.msg_namelen = to.length;
  message.msg_iov = &vector;
  message.msg_iovlen = 1;
  message.msg_control = &control;
  if (ipv6) {
    write_control(message, IPPROTO_IPV6, IPV6_PKTINFO,
                  in6_pktinfo{.ipi6_addr = {}, .ipi6_ifindex = interface});
  } else {
    write_control(
        message, IPPROTO_IP, IP_PKTINFO,
        in_pktinfo{.ipi_ifindex = static_cast<int>(interface), .ipi_spec_dst = {}, .ipi_addr = {}});
  }
  if (sendmsg(fd, &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) {
    return Status::kOk;
  }
  if (errno == EAGAIN || errno == ENOBUFS) {
    return Status::kWouldBlock;
  }
  return errno == EMSGSIZE ? Status::kTooLarge : Status::kDeviceError;
}

std::optional<Received> read_one(int fd, std::span<std::byte> space) noexcept {
  if (fd < 0) {
    return std::nullopt;
  }
  posix::SocketAddress from;
  iovec vector{.iov_base = space.data(), .iov_len = space.size()};
  Control control{};
  msghdr message{};
  message.msg_name = &from.storage;
  message.msg_namelen = from.length;
  message.msg_iov = &vector;
  message.msg_iovlen = 1;
  message.msg_control = &control;
  message.msg_controllen = sizeof control;
  const ssize_t got = recvmsg(fd, &message, MSG_DONTWAIT | MSG_TRUNC);
  std::optional<Peer> peer = got >= 0 ? to_peer(from) : std::nullopt;
  if (!peer) {
    return std::nullopt;
  }
  peer->scope = interface_of(message);
  return Received{.bytes = static_cast<std::size_t>(got), .from = *peer};
}

}  // namespace

std::expected<std::unique_ptr<MdnsPort>, OpenError> MdnsPort::open() {
  posix::UdpSocket ipv4(AF_INET);
  const int error = configure(ipv4, kIpv4Options, posix::make_address(in_addr{}, kPort));
  if (error != 0) {
    return std::unexpected(OpenError{
        std::string("UDP port 5353: ") + std::strerror(error) +
        ": another program has it for itself: end that one, or do without being found by mDNS"});
  }
  posix::UdpSocket ipv6(AF_INET6);
  if (configure(ipv6, kIpv6Options, posix::make_address(in6_addr{}, kPort)) != 0) {
    ipv6 = posix::UdpSocket();
  }
  return std::unique_ptr<MdnsPort>(new MdnsPort(std::move(ipv4), std::move(ipv6)));
}

void MdnsPort::join(std::span<const InterfaceAddress> addresses) noexcept {
  for (const InterfaceAddress& address : addresses) {
    if (!address.multicast) {
      continue;
    }
    // EADDRINUSE: it is a member already.
    if (is_ipv4(address.address)) {
      ip_mreqn group{};
      std::memcpy(&group.imr_multiaddr, kGroup4.data(), kGroup4.size());
      group.imr_ifindex = static_cast<int>(address.interface);
      static_cast<void>(
          setsockopt(ipv4_.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group));
    } else if (ipv6_.is_open()) {
      ipv6_mreq group{};
      std::memcpy(&group.ipv6mr_multiaddr, kGroup6.data(), kGroup6.size());
      group.ipv6mr_interface = address.interface;
      static_cast<void>(
          setsockopt(ipv6_.fd(), IPPROTO_IPV6, IPV6_JOIN_GROUP, &group, sizeof group));
    }
  }
}

Status MdnsPort::send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
                      std::size_t& sent) noexcept {
  const bool ipv6 = !is_ipv4(to.address);
  const int fd = ipv6 ? ipv6_.fd() : ipv4_.fd();
  const auto address = to_socket_address(to, ipv6 ? AF_INET6 : AF_INET);
  sent = 0;
  if (fd < 0 || !address) {
    return Status::kDeviceError;
  }
  for (const auto datagram : datagrams) {
    const Status status = datagram.size() > kMaxDatagram
                              ? Status::kTooLarge
                              : send_one(fd, *address, ipv6, to.scope, datagram);
    if (status != Status::kOk) {
      return status;
    }
    ++sent;
  }
  return Status::kOk;
}

Result<Received> MdnsPort::receive(std::span<std::byte> space, Duration timeout) noexcept {
  for (bool waited = false;; waited = true) {
    // In turn, so that neither keeps the other waiting.
    ipv6_first_ = !ipv6_first_;
    for (const posix::UdpSocket* const socket :
         {ipv6_first_ ? &ipv6_ : &ipv4_, ipv6_first_ ? &ipv4_ : &ipv6_}) {
      if (const std::optional<Received> received = read_one(socket->fd(), space)) {
        return *received;
      }
    }
    if (waited || timeout <= Duration::zero()) {
      return fail(Status::kTimeout);
    }
    std::array entries{pollfd{.fd = ipv4_.fd(), .events = POLLIN, .revents = 0},
                       pollfd{.fd = ipv6_.fd(), .events = POLLIN, .revents = 0}};
    static_cast<void>(posix::wait_for(entries, timeout));
  }
}

}  // namespace stof::hal::linux
