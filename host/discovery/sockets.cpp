#include "host/discovery/sockets.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <unistd.h>

namespace stof::client {
namespace {

template <typename Address>
sockaddr_storage stored(const Address& address) {
  sockaddr_storage out{};
  std::memcpy(&out, &address, sizeof address);
  return out;
}

// The socket functions take every kind of address behind its common head.
const sockaddr* head_of(const sockaddr_storage& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

socklen_t length_of(int family) {
  return family == AF_INET6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in);
}

void set_option(int fd, int level, int name, int value) {
  static_cast<void>(setsockopt(fd, level, name, &value, sizeof value));
}

std::string numeric(const sockaddr_storage& address) {
  std::array<char, NI_MAXHOST> text{};
  const int failed = getnameinfo(head_of(address), length_of(address.ss_family), text.data(),
                                 static_cast<socklen_t>(text.size()), nullptr, 0, NI_NUMERICHOST);
  return failed == 0 ? text.data() : "";
}

}  // namespace

AskingSocket::AskingSocket(int family, std::uint16_t port)
    : family_(family), fd_(socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (fd_ < 0) {
    return;
  }
  if (family == AF_INET6) {
    set_option(fd_, IPPROTO_IPV6, IPV6_V6ONLY, 1);
    set_option(fd_, IPPROTO_IPV6, IPV6_MULTICAST_HOPS, 255);
  } else {
    set_option(fd_, SOL_SOCKET, SO_BROADCAST, 1);
    set_option(fd_, IPPROTO_IP, IP_MULTICAST_TTL, 255);
  }
  set_option(fd_, SOL_SOCKET, SO_REUSEADDR, port != 0 ? 1 : 0);
  const sockaddr_storage any =
      family == AF_INET6 ? make_address(in6_addr{}, port) : make_address(in_addr{}, port);
  if (bind(fd_, head_of(any), length_of(family)) != 0) {
    close(fd_);
    fd_ = -1;
  }
}

AskingSocket::~AskingSocket() {
  if (fd_ >= 0) {
    close(fd_);
  }
}

void AskingSocket::send(const sockaddr_storage& to, std::span<const std::byte> datagram) const {
  if (is_open() && to.ss_family == family_) {
    static_cast<void>(sendto(fd_, datagram.data(), datagram.size(), MSG_NOSIGNAL, head_of(to),
                             length_of(family_)));
  }
}

void AskingSocket::send_by(unsigned interface, const sockaddr_storage& to,
                           std::span<const std::byte> datagram) const {
  if (family_ == AF_INET6) {
    set_option(fd_, IPPROTO_IPV6, IPV6_MULTICAST_IF, static_cast<int>(interface));
  } else {
    ip_mreqn by{};
    by.imr_ifindex = static_cast<int>(interface);
    static_cast<void>(setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_IF, &by, sizeof by));
  }
  send(to, datagram);
}

std::optional<AskingSocket::Read> AskingSocket::receive(std::span<std::byte> space) const {
  if (!is_open()) {
    return std::nullopt;
  }
  sockaddr_storage from{};
  socklen_t length = sizeof from;
  const ssize_t got =
      recvfrom(fd_, space.data(), space.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
  if (got < 0) {
    return std::nullopt;
  }
  return Read{.datagram = space.first(static_cast<std::size_t>(got)), .from = numeric(from)};
}

sockaddr_storage make_address(const in_addr& address, std::uint16_t port) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(port);
  out.sin_addr = address;
  return stored(out);
}

sockaddr_storage make_address(const in6_addr& address, std::uint16_t port, unsigned scope) {
  sockaddr_in6 out{};
  out.sin6_family = AF_INET6;
  out.sin6_port = htons(port);
  out.sin6_addr = address;
  out.sin6_scope_id = scope;
  return stored(out);
}

std::optional<sockaddr_storage> look_up(const std::string& text, std::uint16_t default_port) {
  std::string host = text;
  std::string port = std::to_string(default_port);
  const std::size_t colon = text.rfind(':');
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string::npos || (end + 1 != text.size() && text[end + 1] != ':')) {
      return std::nullopt;
    }
    host = text.substr(1, end - 1);
    port = end + 1 == text.size() ? port : text.substr(end + 2);
  } else if (colon != std::string::npos && text.find(':') == colon) {
    host = text.substr(0, colon);
    port = text.substr(colon + 1);
  }
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (host.empty() || port.empty() ||
      getaddrinfo(host.c_str(), port.c_str(), &hints, &found) != 0) {
    return std::nullopt;
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owned(found, freeaddrinfo);
  sockaddr_storage address{};
  std::memcpy(&address, found->ai_addr, std::min<std::size_t>(found->ai_addrlen, sizeof address));
  return address;
}

Interfaces list_interfaces() {
  Interfaces out;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) {
    return out;
  }
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owned(list, freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if ((entry->ifa_flags & IFF_UP) == 0) {
      continue;
    }
    const unsigned index = if_nametoindex(entry->ifa_name);
    if ((entry->ifa_flags & IFF_MULTICAST) != 0 &&
        std::ranges::find(out.multicast, index) == out.multicast.end()) {
      out.multicast.push_back(index);
    }
    const sockaddr* const broadcast = entry->ifa_broadaddr;
    if ((entry->ifa_flags & IFF_BROADCAST) != 0 && broadcast != nullptr &&
        broadcast->sa_family == AF_INET) {
      sockaddr_in address{};
      std::memcpy(&address, broadcast, sizeof address);
      out.broadcasts.push_back(address.sin_addr);
    }
  }
  return out;
}

}  // namespace stof::client
