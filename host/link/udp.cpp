#include "host/link/udp.h"

#include <cstddef>
#include <span>

#include <netdb.h>
#include <netinet/in.h>

namespace stof::link {
namespace {

constexpr int kBufferBytes = 4 << 20;

std::expected<Address, std::string> resolve(const std::string& host, const std::string& port,
                                            int flags) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error != 0 || found == nullptr) {
    return std::unexpected(std::string(gai_strerror(error)));
  }
  Address address;
  std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
  address.length = found->ai_addrlen;
  freeaddrinfo(found);
  return address;
}

}  // namespace

Socket::Socket(int fd) : fd_(fd) {
  if (fd_ < 0) {
    return;
  }
  for (const int option : {SO_RCVBUF, SO_SNDBUF}) {
    static_cast<void>(setsockopt(fd_, SOL_SOCKET, option, &kBufferBytes, sizeof kBufferBytes));
  }
}

Socket udp_socket(int family) {
  return Socket(::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

std::expected<Address, std::string> resolve_literal(const std::string& host, std::uint16_t port) {
  return resolve(host, std::to_string(port), AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE);
}

std::expected<Address, std::string> resolve_place(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) {
    return std::unexpected("'" + text + "': is not HOST:PORT");
  }
  std::string host = text.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  auto address = resolve(host, text.substr(colon + 1), AI_NUMERICSERV);
  if (!address) {
    return std::unexpected("'" + text + "': " + address.error() + "; give HOST:PORT of the sensor");
  }
  return address;
}

std::uint16_t bound_port(int fd) {
  Address address;
  if (getsockname(fd, address.generic(), &address.length) != 0) {
    return 0;
  }
  std::uint16_t port = 0;  // of both families at the same place
  static_assert(offsetof(sockaddr_in, sin_port) == offsetof(sockaddr_in6, sin6_port));
  const std::span<const std::byte> bytes = std::as_bytes(std::span(&address.storage, 1));
  std::memcpy(&port, bytes.subspan(offsetof(sockaddr_in, sin_port)).data(), sizeof port);
  return ntohs(port);
}

}  // namespace stof::link
