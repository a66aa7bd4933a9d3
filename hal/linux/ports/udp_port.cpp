#include "hal/linux/ports/udp_port.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include <netinet/in.h>

#include "hal/linux/ports/peer_address.h"
#include "posix/poll.h"

namespace stof::hal::linux {
namespace {

// Answers to earlier datagrams that one call may meet: the socket tells each once.
constexpr int kMostOldErrors = 16;
constexpr int kMostDscp = 63;
// Of the shallow stream: the system counts some 2,300 for a datagram of full size, of twice as
// much.
constexpr int kShallowBytes = 16 << 10;

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
    default:  // ENETUNREACH, EHOSTUNREACH, ENETDOWN, EPERM (a firewall), EACCES (broadcast), ...
      return Status::kDeviceError;
  }
}

// Has the system send a message from Peer::own (ip(7), IP_PKTINFO), and by the interface that
// Peer::scope names; from and by where it chooses where those are not known.
class OwnAddress {
 public:
  OwnAddress(const Peer& peer, int family) noexcept {
    // The scope of an IPv6 address stands in the address itself.
    if (peer.own == Peer{}.own && (family == AF_INET6 || peer.scope == 0)) {
      return;
    }
    msghdr message{};
    message.msg_control = control_.data();
    message.msg_controllen = control_.size();
    cmsghdr& entry = *CMSG_FIRSTHDR(&message);
    if (family == AF_INET6) {
      in6_pktinfo info{};
      std::memcpy(&info.ipi6_addr, peer.own.data(), peer.own.size());
      info.ipi6_ifindex = peer.scope;
      write(entry, IPPROTO_IPV6, IPV6_PKTINFO, info);
    } else {
      in_pktinfo info{};
      info.ipi_ifindex = static_cast<int>(peer.scope);
      std::memcpy(&info.ipi_spec_dst, &peer.own[peer.own.size() - sizeof(in_addr)],
                  sizeof(in_addr));
      write(entry, IPPROTO_IP, IP_PKTINFO, info);
    }
  }

  bool is_known() const noexcept { return size_ > 0; }
  void forget() noexcept { size_ = 0; }

  void attach(msghdr& message) noexcept {
    message.msg_control = size_ == 0 ? nullptr : control_.data();
    message.msg_controllen = size_;
  }

 private:
  template <typename Info>
  void write(cmsghdr& entry, int level, int type, const Info& info) noexcept {
    entry.cmsg_level = level;
    entry.cmsg_type = type;
    entry.cmsg_len = CMSG_LEN(sizeof info);
    std::memcpy(CMSG_DATA(&entry), &info, sizeof info);
    size_ = CMSG_SPACE(sizeof info);
  }

  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(in6_pktinfo))> control_{};
  std::size_t size_ = 0;
};

std::vector<posix::SocketOption> socket_options(const UdpPortOptions& options, int family) {
  const int traffic_class = options.dscp << 2;  // the lower two bits are ECN's
  // Never fragments, and never believes who says that a path takes less: anybody can (ICMP).
  std::vector<posix::SocketOption> wanted{
      {IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_PROBE},
      {SOL_SOCKET, SO_BROADCAST, options.broadcast ? 1 : 0},
  };
  if (options.broadcast) {
    wanted.push_back({IPPROTO_IP, IP_TTL, 1});  // for neighbours alone
  }
  // No class is the system's own: it is not asked for one.
  if (options.dscp != 0) {
    wanted.push_back({IPPROTO_IP, IP_TOS, traffic_class});
  }
  if (family == AF_INET6) {
    wanted.push_back({IPPROTO_IPV6, IPV6_V6ONLY, 0});  // IPv4 goes through this socket, too
    wanted.push_back({IPPROTO_IPV6, IPV6_MTU_DISCOVER, IPV6_PMTUDISC_PROBE});
    if (options.dscp != 0) {
      wanted.push_back({IPPROTO_IPV6, IPV6_TCLASS, traffic_class});
    }
  }
  return wanted;
}

Status send_batch(int fd, std::span<mmsghdr> messages, std::size_t& sent) noexcept {
  int old_errors = 0;
  while (sent < messages.size()) {
    const std::span<mmsghdr> rest = messages.subspan(sent);
    const int count = sendmmsg(fd, rest.data(), static_cast<unsigned>(rest.size()), MSG_NOSIGNAL);
    if (count >= 0) {
      sent += static_cast<std::size_t>(count);
      continue;
    }
    const bool again =
        errno == EINTR || (posix::answers_earlier(errno) && old_errors++ < kMostOldErrors);
    if (!again) {
      return status_of(errno);
    }
  }
  return Status::kOk;
}

}  // namespace

std::expected<std::unique_ptr<UdpPort>, OpenError> UdpPort::open(const UdpPortOptions& options) {
  const std::string place = "UDP port " + std::to_string(options.port) + ": ";
  if (options.dscp < 0 || options.dscp > kMostDscp) {
    return std::unexpected(
        OpenError{place + "no DSCP " + std::to_string(options.dscp) + "; give 0 to 63"});
  }
  int family = options.ipv4_only ? AF_INET : AF_INET6;
  posix::UdpSocket socket(family);
  if (!socket.is_open() && family == AF_INET6) {
    family = AF_INET;
    socket = posix::UdpSocket(family);
  }
  if (!socket.is_open()) {
    return std::unexpected(
        OpenError{place + std::strerror(errno) + "; this system gives no socket"});
  }
  std::unique_ptr<UdpPort> port(new UdpPort(std::move(socket), family));
  if (const int error = port->configure(options); error != 0) {
    return std::unexpected(OpenError{place + std::strerror(error) +
                                     "; close the program that uses it or take another port"});
  }
  return port;
}

int UdpPort::configure(const UdpPortOptions& options) {
  send_buffer_ = socket_.set_buffer(posix::UdpSocket::Buffer::kSend, options.buffer_bytes);
  receive_buffer_ = socket_.set_buffer(posix::UdpSocket::Buffer::kReceive, options.buffer_bytes);
  refusals_ = options.refusals;
  static_cast<void>(socket_.count_drops());  // else overruns are not told, nothing else
  // Else the system answers from the address that it takes for the nearest one.
  static_cast<void>(socket_.tell_own_address(family_));
  hear_refusals(socket_);
  const std::vector<posix::SocketOption> wanted = socket_options(options, family_);
  int error = socket_.set(wanted);
  if (error == 0) {
    error = socket_.bind(family_ == AF_INET6 ? posix::make_address(in6_addr{}, options.port)
                                             : posix::make_address(in_addr{}, options.port));
  }
  port_ = error == 0 ? socket_.port() : 0;
  if (error == 0 && options.streams) {
    streams_ = StreamSockets::open(socket_, family_, kStreams, wanted, options.buffer_bytes);
    if (!streams_.empty()) {
      static_cast<void>(streams_.all()[kShallowStream].set_buffer(posix::UdpSocket::Buffer::kSend,
                                                                  kShallowBytes));
    }
    for (const posix::UdpSocket& stream : streams_.all()) {
      hear_refusals(stream);
    }
  }
  return error;
}

// Anybody can make up refusals, and while a thread reads many each makes a call of whoever sends
// fail: a port that needs none hears none. Where the system refuses, they are not told.
void UdpPort::hear_refusals(const posix::UdpSocket& socket) const noexcept {
  if (refusals_) {
    static_cast<void>(socket.set({IPPROTO_IP, IP_RECVERR, 1}));
    if (family_ == AF_INET6) {
      static_cast<void>(socket.set({IPPROTO_IPV6, IPV6_RECVERR, 1}));
    }
  }
}

Status UdpPort::send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
                     std::size_t& sent) noexcept {
  return send_by(socket_.fd(), to, datagrams, sent);
}

Status UdpPort::stream(std::size_t which, const Peer& to,
                       std::span<const std::span<const std::byte>> datagrams,
                       std::size_t& sent) noexcept {
  const std::span<const posix::UdpSocket> streams = streams_.all();
  return send_by(which < streams.size() ? streams[which].fd() : socket_.fd(), to, datagrams, sent);
}

Status UdpPort::send_by(int fd, const Peer& to,
                        std::span<const std::span<const std::byte>> datagrams,
                        std::size_t& sent) const noexcept {
  sent = 0;
  std::optional<posix::SocketAddress> address = to_socket_address(to, family_);
  if (!address) {
    return datagrams.empty() ? Status::kOk : Status::kDeviceError;
  }
  OwnAddress own(to, family_);
  while (sent < datagrams.size()) {
    std::array<iovec, posix::DatagramBatch::kMost> vectors;
    std::array<mmsghdr, posix::DatagramBatch::kMost> messages;
    std::size_t count = 0;
    while (count < posix::DatagramBatch::kMost && sent + count < datagrams.size() &&
           datagrams[sent + count].size() <= kMaxDatagram) {
      const std::span<const std::byte> datagram = datagrams[sent + count];
      vectors[count] = {.iov_base = const_cast<std::byte*>(datagram.data()),  // NOLINT: only read
                        .iov_len = datagram.size()};
      messages[count] = {};
      messages[count].msg_hdr.msg_name = &address->storage;
      messages[count].msg_hdr.msg_namelen = address->length;
      messages[count].msg_hdr.msg_iov = &vectors[count];
      messages[count].msg_hdr.msg_iovlen = 1;
      own.attach(messages[count].msg_hdr);
      ++count;
    }
    if (count == 0) {
      return Status::kTooLarge;
    }
    std::size_t taken = 0;
    const Status status = send_batch(fd, std::span(messages).first(count), taken);
    sent += taken;
    // This machine may not have that address any more. What goes to all of a link never goes to
    // another one.
    if (status == Status::kDeviceError && own.is_known() &&
        (family_ == AF_INET6 || to.scope == 0)) {
      own.forget();
      continue;
    }
    if (status != Status::kOk) {
      return status;
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
  const std::span<const std::byte> datagram = batch_.datagram(index);
  std::ranges::copy(datagram.first(std::min(datagram.size(), space.size())), space.begin());
  Received received{.bytes = batch_.whole_size(index),
                    .from = to_peer(batch_.from(index)).value_or(Peer{})};
  std::memcpy(received.from.own.data(), &batch_.own(index), received.from.own.size());
  received.link = batch_.link(index);
  return received;
}

// Reads what has arrived. kOk: at least one datagram; kTimeout: none.
Status UdpPort::fill() noexcept {
  read_ = 0;
  next_ = 0;
  for (int old_errors = 0;;) {
    const auto count = batch_.read(socket_.fd());
    if (count && *count > 0) {
      read_ = *count;
      return Status::kOk;
    }
    const int error = count ? EAGAIN : count.error();
    if (posix::answers_earlier(error) && old_errors++ < kMostOldErrors) {
      unreachable_.read(socket_.fd());
    } else if (error != EINTR) {
      const bool nothing = error == EAGAIN || error == ENOMEM || posix::answers_earlier(error);
      return nothing ? Status::kTimeout : Status::kDeviceLost;
    }
  }
}

// kOk: something can be read; kTimeout: nothing, or refusals only.
Status UdpPort::wait(Duration timeout) noexcept {
  std::array<pollfd, 1 + kStreams> entries{
      pollfd{.fd = socket_.fd(), .events = POLLIN, .revents = 0}};
  std::size_t count = 1;
  if (refusals_) {  // one may come to any of the sockets, whichever sent
    for (const posix::UdpSocket& stream : streams_.all()) {
      entries[count++] = {.fd = stream.fd(), .events = 0, .revents = 0};
    }
  }
  const auto ready = posix::wait_for(std::span(entries).first(count), timeout);
  const short told = entries[0].revents;
  if (!ready || (told & POLLNVAL) != 0) {
    return Status::kDeviceLost;
  }
  for (const pollfd& entry : std::span(entries).first(count)) {
    if ((entry.revents & POLLERR) != 0) {
      unreachable_.read(entry.fd);
    }
  }
  return (told & POLLIN) != 0 ? Status::kOk : Status::kTimeout;
}

}  // namespace stof::hal::linux
