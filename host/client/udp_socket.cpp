#include "host/client/udp_socket.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

namespace stof::client {
namespace {

std::optional<SocketAddress> parse_address(const std::string& text, std::uint16_t port) {
  SocketAddress address;
  sockaddr_in v4{};
  if (inet_pton(AF_INET, text.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    std::memcpy(&address.storage, &v4, sizeof v4);
    address.length = sizeof v4;
    return address;
  }
  sockaddr_in6 v6{};
  if (inet_pton(AF_INET6, text.c_str(), &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    std::memcpy(&address.storage, &v6, sizeof v6);
    address.length = sizeof v6;
    return address;
  }
  return std::nullopt;
}

std::uint16_t bound_port(int fd) {
  SocketAddress address;
  address.length = sizeof address.storage;
  return getsockname(fd, address.generic(), &address.length) == 0 ? address.port() : 0;
}

// Refusals of what was sent before, and ways that are closed for now: the socket works on.
bool passes(int error) {
  return error == ECONNREFUSED || error == EHOSTUNREACH || error == ENETUNREACH ||
         error == ENETDOWN || error == EPROTO || error == EACCES || error == EPERM ||
         error == EMSGSIZE;
}

int make_socket(int family) {
  return ::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
}

void set_option(int fd, int name, int value) {
  static_cast<void>(setsockopt(fd, SOL_SOCKET, name, &value, sizeof value));
}

}  // namespace

UdpSocket::UdpSocket(int fd) : fd_(fd) {
  for (std::size_t i = 0; i < kBatch; ++i) {
    vectors_[i] = {.iov_base = space_[i].data(), .iov_len = kSpace};
    messages_[i] = {};
    messages_[i].msg_hdr.msg_iov = &vectors_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
    messages_[i].msg_hdr.msg_control = control_[i].data();
  }
}

UdpSocket::~UdpSocket() { close(fd_); }

std::expected<std::unique_ptr<UdpSocket>, OpenError> UdpSocket::open(const std::string& address,
                                                                     std::uint16_t port,
                                                                     int buffer_bytes) {
  std::optional<SocketAddress> at = parse_address(address, port);
  if (!at) {
    return std::unexpected(
        OpenError{Status::kInvalidArgument,
                  "listening address '" + address +
                      "': not an IPv4 or IPv6 address; use 0.0.0.0 to listen at every interface"});
  }
  const std::string place = "UDP port " + std::to_string(port) + " at " + address + ": ";
  const int fd = make_socket(at->storage.ss_family);
  if (fd < 0) {
    return std::unexpected(OpenError{
        Status::kDeviceError, place + std::strerror(errno) + "; this system gives no socket"});
  }
  std::unique_ptr<UdpSocket> socket(new UdpSocket(fd));
  if (bind(fd, at->generic(), at->length) != 0) {
    return std::unexpected(OpenError{
        Status::kDeviceError,
        place + std::strerror(errno) + "; close the program that uses it or take another port"});
  }
  socket->prepare(buffer_bytes);
  socket->place_ = address + ":" + std::to_string(socket->port_);
  return socket;
}

std::expected<std::unique_ptr<UdpSocket>, OpenError> UdpSocket::connect(std::string_view sensor,
                                                                        int buffer_bytes) {
  auto addresses = resolve_sensor(sensor);
  if (!addresses) {
    return std::unexpected(std::move(addresses.error()));
  }
  int error = EADDRNOTAVAIL;
  for (SocketAddress& address : *addresses) {
    const int fd = make_socket(address.storage.ss_family);
    if (fd < 0) {
      error = errno;
      continue;
    }
    std::unique_ptr<UdpSocket> socket(new UdpSocket(fd));
    if (::connect(fd, address.generic(), address.length) == 0) {
      socket->prepare(buffer_bytes);
      socket->place_ = address.text();
      return socket;
    }
    error = errno;
  }
  return std::unexpected(OpenError{Status::kDeviceError,
                                   "sensor '" + std::string(sensor) + "': " + std::strerror(error) +
                                       "; check the network and the route to that host"});
}

void UdpSocket::prepare(int buffer_bytes) {
  port_ = bound_port(fd_);
  // The forced size passes net.core.rmem_max and needs CAP_NET_ADMIN.
  set_option(fd_, SO_RCVBUF, buffer_bytes);
  set_option(fd_, SO_RCVBUFFORCE, buffer_bytes);
  int got = 0;
  socklen_t length = sizeof got;
  if (getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &got, &length) == 0) {
    buffer_bytes_ = got / 2;  // the system doubles what is set, for its own bookkeeping
  }
  set_option(fd_, SO_RXQ_OVFL, 1);  // without it drops are not told apart, nothing else
}

Status UdpSocket::send(std::span<const std::byte> datagram) {
  // The first error may answer an earlier datagram.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (::send(fd_, datagram.data(), datagram.size(), MSG_NOSIGNAL) >= 0) {
      return Status::kOk;
    }
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS || errno == ENOMEM) {
      return Status::kWouldBlock;
    }
    if (errno != EINTR && !passes(errno)) {
      return Status::kDeviceLost;
    }
    refused_ = refused_ || errno == ECONNREFUSED;
  }
  return Status::kDeviceError;
}

Result<std::size_t> UdpSocket::receive() {
  for (mmsghdr& message : messages_) {
    message.msg_hdr.msg_controllen = kControlSpace;
  }
  int count = recvmmsg(fd_, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
  if (count < 0 && passes(errno)) {
    refused_ = refused_ || errno == ECONNREFUSED;
    count = recvmmsg(fd_, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
  }
  if (count < 0) {
    const bool nothing = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || passes(errno);
    return nothing ? Result<std::size_t>(0) : fail(Status::kDeviceLost);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    note_drops(messages_[i].msg_hdr);
  }
  return static_cast<std::size_t>(count);
}

std::span<const std::byte> UdpSocket::datagram(std::size_t index) const {
  return std::span(space_[index]).first(std::min<std::size_t>(messages_[index].msg_len, kSpace));
}

void UdpSocket::note_drops(const msghdr& message) {
  // Only the first entry can be it: nothing else was asked for.
  const cmsghdr* const entry = CMSG_FIRSTHDR(&message);
  if (entry == nullptr || entry->cmsg_level != SOL_SOCKET || entry->cmsg_type != SO_RXQ_OVFL) {
    return;
  }
  std::uint32_t count = 0;
  std::memcpy(&count, CMSG_DATA(entry), sizeof count);
  dropped_ += count - kernel_count_;
  kernel_count_ = count;
}

Status UdpSocket::wait(Duration timeout) {
  pollfd entry{.fd = fd_, .events = POLLIN, .revents = 0};
  const auto whole = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  const int ready = poll(&entry, 1, static_cast<int>(std::clamp<std::int64_t>(whole, 0, 60'000)));
  if (ready < 0) {
    return errno == EINTR ? Status::kTimeout : Status::kDeviceLost;
  }
  if (ready > 0 && (entry.revents & POLLNVAL) != 0) {  // POLLERR: receive() hears which
    return Status::kDeviceLost;
  }
  return ready > 0 ? Status::kOk : Status::kTimeout;
}

}  // namespace stof::client
