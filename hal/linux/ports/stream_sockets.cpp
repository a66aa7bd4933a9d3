#include "hal/linux/ports/stream_sockets.h"

#include <utility>

#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "posix/socket_address.h"

namespace stof::hal::linux {
namespace {

constexpr posix::SocketOption kShared{SOL_SOCKET, SO_REUSEPORT, 1};

// A program that returns 0, whatever comes (socket(7)).
bool attach_zero(const posix::UdpSocket& socket, int option) noexcept {
  sock_filter zero{.code = BPF_RET | BPF_K, .jt = 0, .jf = 0, .k = 0};
  const sock_fprog program{.len = 1, .filter = &zero};
  return setsockopt(socket.fd(), SOL_SOCKET, option, &program, sizeof program) == 0;
}

// Of sockets at one port the first that was bound receives, whoever sends: of index 0.
bool first_receives(const posix::UdpSocket& socket) noexcept {
  return attach_zero(socket, SO_ATTACH_REUSEPORT_CBPF);
}

// What is sent to all hosts comes to every socket of a port: of such a datagram 0 bytes are kept.
bool hears_nothing(const posix::UdpSocket& socket) noexcept {
  return attach_zero(socket, SO_ATTACH_FILTER);
}

}  // namespace

StreamSockets StreamSockets::open(const posix::UdpSocket& receiver, int family, std::size_t count,
                                  std::span<const posix::SocketOption> options, int buffer_bytes) {
  StreamSockets streams;
  const std::uint16_t port = receiver.port();
  // Not before it was bound: two programs must not share a port unawares.
  if (count == 0 || port == 0 || receiver.set(kShared) != 0) {
    return streams;
  }
  for (std::size_t i = 0; i < count; ++i) {
    posix::UdpSocket socket(family);
    const bool bound = socket.is_open() && hears_nothing(socket) && socket.set(kShared) == 0 &&
                       socket.set(options) == 0 &&
                       socket.bind(family == AF_INET6 ? posix::make_address(in6_addr{}, port)
                                                      : posix::make_address(in_addr{}, port)) == 0;
    if (!bound || (i == 0 && !first_receives(receiver))) {
      static_cast<void>(receiver.set({SOL_SOCKET, SO_REUSEPORT, 0}));
      return {};
    }
    static_cast<void>(socket.set_buffer(posix::UdpSocket::Buffer::kSend, buffer_bytes));
    streams.sockets_.push_back(std::move(socket));
  }
  // No other program can join: Linux asks every socket at the port.
  static_cast<void>(receiver.set({SOL_SOCKET, SO_REUSEPORT, 0}));
  return streams;
}

}  // namespace stof::hal::linux
