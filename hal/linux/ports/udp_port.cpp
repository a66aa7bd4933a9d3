#include "hal/linux/ports/udp_port.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <string>

#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include "hal/linux/ports/peer_address.h"

namespace stof::hal::linux {
namespace {

// Answers to earlier datagrams that one call may meet: the socket tells each once.
constexpr int kMostOldErrors = 16;
constexpr int kMostDscp = 63;

bool set_option(int fd, int level, int name, int value) noexcept {
  return setsockopt(fd, level, name, &value, sizeof value) == 0;
}

// The upper six bits of that byte; the lower two are ECN's.
bool set_class(int fd, int family, int dscp) noexcept {
  return set_option(fd, IPPROTO_IP, IP_TOS, dscp << 2) &&
         (family != AF_INET6 || set_option(fd, IPPROTO_IPV6, IPV6_TCLASS, dscp << 2));
}

// The forced size passes net.core.?mem_max and needs CAP_NET_ADMIN.
int set_buffer(int fd, int name, int forced_name, int bytes) noexcept {
  static_cast<void>(set_option(fd, SOL_SOCKET, name, bytes));
  static_cast<void>(set_option(fd, SOL_SOCKET, forced_name, bytes));
  int got = 0;
  socklen_t length = sizeof got;
  static_cast<void>(getsockopt(fd, SOL_SOCKET, name, &got, &length));
  return got / 2;  // the system doubles what is set, for its own bookkeeping
}

sockaddr* generic(sockaddr_storage& storage) noexcept {
  return reinterpret_cast<sockaddr*>(&storage);  // NOLINT: the sockets' own interface
}

// ICMP answers come as errors of whatever call is made next, to whomever.
bool answers_earlier(int error) noexcept {
  return error == ECONNREFUSED || error == EHOSTUNREACH || error == ENETUNREACH ||
         error == EPROTO || error == ENOPROTOOPT || error == EACCES || error == EMSGSIZE;
}

Status status_of(int error) noexcept {
  switch (error) {
    case EAGAIN:
    case ENOBUFS:
    case ENOMEM:
      return Status::kWouldBlock;
    case EMSGSIZE:
      return Status::kTooLarge;
    case EBADF:
    case ENOTSOCK:
    case EPIPE:
      return Status::kDeviceLost;
    default:  // ENETUNREACH, EHOSTUNREACH, ENETDOWN, EPERM (a firewall), ...
      return Status::kDeviceError;
  }
}

}  // namespace

UdpPort::UdpPort(int fd, int family) noexcept : fd_(fd), family_(family) {
  for (std::size_t i = 0; i < kBatch; ++i) {
    vectors_[i] = {.iov_base = space_[i].data(), .iov_len = space_[i].size()};
    messages_[i] = {};
    messages_[i].msg_hdr.msg_iov = &vectors_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
    messages_[i].msg_hdr.msg_name = &from_[i];
    messages_[i].msg_hdr.msg_control = control_[i].data();
  }
}

UdpPort::~UdpPort() { close(fd_); }

std::expected<std::unique_ptr<UdpPort>, OpenError> UdpPort::open(const UdpPortOptions& options) {
  const std::string place = "UDP port " + std::to_string(options.port) + ": ";
  if (options.dscp < 0 || options.dscp > kMostDscp) {
    return std::unexpected(
        OpenError{place + "no DSCP " + std::to_string(options.dscp) + "; give 0 to 63"});
  }
  int family = options.ipv4_only ? AF_INET : AF_INET6;
  int fd = socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0 && family == AF_INET6) {
    family = AF_INET;
    fd = socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  }
  if (fd < 0) {
    return std::unexpected(
        OpenError{place + std::strerror(errno) + "; this system gives no socket"});
  }
  std::unique_ptr<UdpPort> port(new UdpPort(fd, family));
  if (!port->configure(options)) {
    return std::unexpected(OpenError{place + std::strerror(errno) +
                                     "; close the program that uses it or take another port"});
  }
  return port;
}

bool UdpPort::configure(const UdpPortOptions& options) noexcept {
  send_buffer_ = set_buffer(fd_, SO_SNDBUF, SO_SNDBUFFORCE, options.buffer_bytes);
  receive_buffer_ = set_buffer(fd_, SO_RCVBUF, SO_RCVBUFFORCE, options.buffer_bytes);
  // Without these two, overruns and refusals are not told, nothing else.
  static_cast<void>(set_option(fd_, SOL_SOCKET, SO_RXQ_OVFL, 1));
  static_cast<void>(set_option(fd_, IPPROTO_IP, IP_RECVERR, 1));
  if (options.dscp != 0 && !set_class(fd_, family_, options.dscp)) {
    return false;
  }
  Peer any;
  if (family_ == AF_INET6) {
    static_cast<void>(set_option(fd_, IPPROTO_IPV6, IPV6_RECVERR, 1));
    // IPv4 goes through this socket, too.
    if (!set_option(fd_, IPPROTO_IPV6, IPV6_V6ONLY, 0) ||
        !set_option(fd_, IPPROTO_IPV6, IPV6_MTU_DISCOVER, IPV6_PMTUDISC_DO)) {
      return false;
    }
  } else {
    any = {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0, 0, 0, 0}};
  }
  any.port = options.port;
  std::optional<SocketAddress> address = to_socket_address(any, family_);
  if (!address || !set_option(fd_, IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO) ||
      !set_option(fd_, SOL_SOCKET, SO_BROADCAST, 1) ||
      bind(fd_, generic(address->storage), address->length) != 0) {
    return false;
  }
  sockaddr_storage bound{};
  socklen_t length = sizeof bound;
  if (getsockname(fd_, generic(bound), &length) != 0) {
    return false;
  }
  const std::optional<Peer> self = to_peer(bound);
  port_ = self ? self->port : 0;
  return self.has_value();
}

Status UdpPort::send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
                     std::size_t& sent) noexcept {
  sent = 0;
  std::optional<SocketAddress> address = to_socket_address(to, family_);
  if (!address) {
    return datagrams.empty() ? Status::kOk : Status::kDeviceError;
  }
  while (sent < datagrams.size()) {
    std::array<iovec, kBatch> vectors;
    std::array<mmsghdr, kBatch> messages;
    std::size_t count = 0;
    while (count < kBatch && sent + count < datagrams.size() &&
           datagrams[sent + count].size() <= kMaxDatagram) {
      const std::span<const std::byte> datagram = datagrams[sent + count];
      vectors[count] = {.iov_base = const_cast<std::byte*>(datagram.data()),  // NOLINT: only read
                        .iov_len = datagram.size()};
      messages[count] = {};
      messages[count].msg_hdr.msg_name = &address->storage;
      messages[count].msg_hdr.msg_namelen = address->length;
      messages[count].msg_hdr.msg_iov = &vectors[count];
      messages[count].msg_hdr.msg_iovlen = 1;
      ++count;
    }
    if (count == 0) {
      return Status::kTooLarge;
    }
    std::size_t taken = 0;
    const Status status = send_batch(std::span(messages).first(count), taken);
    sent += taken;
    if (status != Status::kOk) {
      return status;
    }
  }
  return Status::kOk;
}

Status UdpPort::send_batch(std::span<mmsghdr> messages, std::size_t& sent) const noexcept {
  int old_errors = 0;
  while (sent < messages.size()) {
    const std::span<mmsghdr> rest = messages.subspan(sent);
    const int count = sendmmsg(fd_, rest.data(), static_cast<unsigned>(rest.size()), MSG_NOSIGNAL);
    if (count >= 0) {
      sent += static_cast<std::size_t>(count);
      continue;
    }
    const bool again = errno == EINTR || (answers_earlier(errno) && old_errors++ < kMostOldErrors);
    if (!again) {
      return status_of(errno);
    }
  }
  return Status::kOk;
}

Result<Received> UdpPort::receive(std::span<std::byte> space, Duration timeout) noexcept {
  if (next_ == read_) {
    Status status = fill();
    if (status == Status::kTimeout && timeout > Duration::zero()) {
      status = wait(timeout);
      if (status == Status::kOk) {
        status = fill();
      }
    }
    if (status != Status::kOk) {
      return fail(status);
    }
  }
  const std::size_t index = next_++;
  const std::size_t bytes = messages_[index].msg_len;
  const std::optional<Peer> from = to_peer(from_[index]);
  const std::size_t held = std::min({bytes, space.size(), space_[index].size()});
  std::ranges::copy(std::span(space_[index]).first(held), space.begin());
  return Received{.bytes = bytes, .from = from.value_or(Peer{})};
}

// Reads what has arrived. kOk: at least one datagram; kTimeout: none.
Status UdpPort::fill() noexcept {
  read_ = 0;
  next_ = 0;
  for (mmsghdr& message : messages_) {
    message.msg_hdr.msg_namelen = sizeof(sockaddr_storage);
    message.msg_hdr.msg_controllen = kControlSpace;
  }
  for (int old_errors = 0;;) {
    // MSG_TRUNC: the whole length of what is too long.
    const int count = recvmmsg(fd_, messages_.data(), kBatch, MSG_DONTWAIT | MSG_TRUNC, nullptr);
    if (count > 0) {
      read_ = static_cast<std::size_t>(count);
      break;
    }
    if (count < 0 && answers_earlier(errno) && old_errors++ < kMostOldErrors) {
      refusals_.read(fd_);
    } else if (count == 0 || errno != EINTR) {
      const bool nothing = count == 0 || errno == EAGAIN || errno == EWOULDBLOCK ||
                           errno == ENOMEM || answers_earlier(errno);
      return nothing ? Status::kTimeout : Status::kDeviceLost;
    }
  }
  for (std::size_t i = 0; i < read_; ++i) {
    note_overruns(messages_[i].msg_hdr);
  }
  return Status::kOk;
}

// kOk: something can be read; kTimeout: nothing, or refusals only.
Status UdpPort::wait(Duration timeout) noexcept {
  pollfd entry{.fd = fd_, .events = POLLIN, .revents = 0};
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(timeout);
  timespec limit{};
  limit.tv_sec = static_cast<time_t>(whole.count());
  limit.tv_nsec = static_cast<long>((timeout - whole).count());  // NOLINT: timespec's
  const int ready = ppoll(&entry, 1, &limit, nullptr);
  if (ready < 0) {
    return errno == EINTR ? Status::kTimeout : Status::kDeviceLost;
  }
  if ((entry.revents & POLLNVAL) != 0) {
    return Status::kDeviceLost;
  }
  if ((entry.revents & POLLERR) != 0) {
    refusals_.read(fd_);
  }
  return (entry.revents & POLLIN) != 0 ? Status::kOk : Status::kTimeout;
}

void UdpPort::note_overruns(const msghdr& message) noexcept {
  const cmsghdr* const entry = CMSG_FIRSTHDR(&message);
  if (entry == nullptr || entry->cmsg_level != SOL_SOCKET || entry->cmsg_type != SO_RXQ_OVFL) {
    return;
  }
  std::uint32_t count = 0;
  std::memcpy(&count, CMSG_DATA(entry), sizeof count);
  overruns_.fetch_add(count - kernel_overruns_, std::memory_order_relaxed);
  kernel_overruns_ = count;
}

}  // namespace stof::hal::linux
