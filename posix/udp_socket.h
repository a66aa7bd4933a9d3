#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "posix/fd.h"
#include "posix/socket_address.h"

namespace stof::posix {

struct SocketOption {
  int level;  // SOL_SOCKET, IPPROTO_IP, IPPROTO_IPV6
  int name;
  int value;
};

// A UDP socket whose calls never block. An int that is returned is 0 or an errno, unless said
// otherwise.
class UdpSocket {
 public:
  enum class Buffer : std::uint8_t { kSend, kReceive };

  UdpSocket() noexcept = default;  // none: not open
  // family: AF_INET or AF_INET6. Not open: the system gives none, errno says why.
  explicit UdpSocket(int family) noexcept;

  bool is_open() const noexcept { return fd_.is_open(); }
  int fd() const noexcept { return fd_.get(); }

  int set(const SocketOption& option) const noexcept;
  // In order, up to the first that the system refuses.
  int set(std::span<const SocketOption> options) const noexcept;
  // Asks for so many bytes, beyond the system's limit where the program may; returns how many
  // the system grants.
  int set_buffer(Buffer which, int bytes) const noexcept;
  // Has the system count datagrams that find the receive buffer full (DatagramBatch::dropped()).
  int count_drops() const noexcept;
  // Has the system stamp each datagram when it arrives (DatagramBatch::arrived()).
  int stamp_arrivals() const noexcept;
  // Has the system tell where each datagram was sent to (DatagramBatch::own()).
  int tell_own_address(int family) const noexcept;
  // With port 0 any free one.
  int bind(const SocketAddress& at) const noexcept;
  // From now on send() goes there, and only what comes from there is received.
  int connect(const SocketAddress& to) const noexcept;
  std::uint16_t port() const noexcept;  // its own; 0: not bound

  int send(std::span<const std::byte> datagram) const noexcept;
  int send_to(const SocketAddress& to, std::span<const std::byte> datagram) const noexcept;
  // The same of an IPv4 socket, by that interface, whatever the routes say.
  int send_by(unsigned interface, const SocketAddress& to,
              std::span<const std::byte> datagram) const noexcept;
  // The first bytes of the next datagram, as many as fit: how many. EAGAIN: there is none.
  std::expected<std::size_t, int> receive(std::span<std::byte> space,
                                          SocketAddress* from = nullptr) const noexcept;

 private:
  Fd fd_;
};

// Whether an error that a call met answers what was sent before (ICMP), to whomever: the next call
// may do.
bool answers_earlier(int error) noexcept;

}  // namespace stof::posix
