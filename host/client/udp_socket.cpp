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

struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

// The socket interface takes sockaddr*, whatever is behind it.
sockaddr* generic(Address& address) {
  return reinterpret_cast<sockaddr*>(&address.storage);  // NOLINT: the sockets' own interface
}

std::optional<Address> parse_address(const std::string& text, std::uint16_t port) {
  Address address;
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
  Address address;
  address.length = sizeof address.storage;
  if (getsockname(fd, generic(address), &address.length) != 0) {
    return 0;
  }
  if (address.storage.ss_family == AF_INET) {
    sockaddr_in v4{};
    std::memcpy(&v4, &address.storage, sizeof v4);
    return ntohs(v4.sin_port);
  }
  sockaddr_in6 v6{};
  std::memcpy(&v6, &address.storage, sizeof v6);
  return ntohs(v6.sin6_port);
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

std::expected<std::unique_ptr<UdpSocket>, UdpSocket::Error> UdpSocket::open(
    const std::string& address, std::uint16_t port, int buffer_bytes) {
  std::optional<Address> at = parse_address(address, port);
  if (!at) {
    return std::unexpected(
        Error{Status::kInvalidArgument,
              "listening address '" + address +
                  "': not an IPv4 or IPv6 address; use 0.0.0.0 to listen at every interface"});
  }
  const std::string place = "UDP port " + std::to_string(port) + " at " + address + ": ";
  const int fd = ::socket(at->storage.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) {
    return std::unexpected(Error{Status::kDeviceError,
                                 place + std::strerror(errno) + "; this system gives no socket"});
  }
  std::unique_ptr<UdpSocket> socket(new UdpSocket(fd));
  if (bind(fd, generic(*at), at->length) != 0) {
    return std::unexpected(Error{
        Status::kDeviceError,
        place + std::strerror(errno) + "; close the program that uses it or take another port"});
  }
  socket->port_ = bound_port(fd);
  socket->ask_for_buffer(buffer_bytes);
  set_option(fd, SO_RXQ_OVFL, 1);  // without it drops are not told apart, nothing else
  return socket;
}

void UdpSocket::ask_for_buffer(int bytes) {
  // The forced size passes net.core.rmem_max and needs CAP_NET_ADMIN.
  set_option(fd_, SO_RCVBUF, bytes);
  set_option(fd_, SO_RCVBUFFORCE, bytes);
  int got = 0;
  socklen_t length = sizeof got;
  if (getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &got, &length) == 0) {
    buffer_bytes_ = got / 2;  // the system doubles what is set, for its own bookkeeping
  }
}

Result<std::size_t> UdpSocket::receive() {
  for (mmsghdr& message : messages_) {
    message.msg_hdr.msg_controllen = kControlSpace;
  }
  const int count = recvmmsg(fd_, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
  if (count < 0) {
    const bool nothing = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
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
  if (ready > 0 && (entry.revents & (POLLERR | POLLNVAL)) != 0) {
    return Status::kDeviceLost;
  }
  return ready > 0 ? Status::kOk : Status::kTimeout;
}

}  // namespace stof::client
