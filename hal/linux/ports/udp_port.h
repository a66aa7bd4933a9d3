#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <span>
#include <utility>

#include <sys/socket.h>

#include "hal/datagram_port.h"
#include "hal/linux/open_error.h"
#include "hal/linux/ports/stream_sockets.h"
#include "hal/linux/ports/unreachable_peers.h"
#include "posix/datagram_batch.h"
#include "posix/udp_socket.h"

namespace stof::hal::linux {

struct UdpPortOptions {
  std::uint16_t port = 0;      // 0: any free one
  int buffer_bytes = 4 << 20;  // asked of the system for each direction
  bool ipv4_only = false;      // also where there is IPv6
  int dscp = 0;                // 0 .. 63: class of what is sent (RFC 2474), IPv6 and IPv4
  bool broadcast = false;      // may send to all hosts of a link, and to nobody beyond it
  bool streams = false;        // a queue for each stream (StreamSockets)
  bool refusals = false;       // hears of peers that do not listen: take_unreachable()
};

// A UDP port at every interface, IPv6 and IPv4 (IPv4 alone where the system has no IPv6), that
// never sends IP fragments, nor to a broadcast address where it was not asked to (whoever forges
// one as his own gets no answer: kDeviceError), and takes no answer of the network (ICMP) for a
// smaller path. A peer that it heard is answered from the address that it spoke to (Peer::own).
// What a peer does not take waits in the queue of its stream alone, where the port was asked for
// them. An answer "nobody listens there" to an earlier datagram never costs a later one; only a
// port that was asked to hears of them. Any thread may send, also several at once; one thread
// receives and takes refusals.
class UdpPort final : public hal::DatagramPort {
 public:
  static std::expected<std::unique_ptr<UdpPort>, OpenError> open(const UdpPortOptions& options);

  Status send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override;
  Status stream(std::size_t which, const Peer& to,
                std::span<const std::span<const std::byte>> datagrams,
                std::size_t& sent) noexcept override;
  Result<Received> receive(std::span<std::byte> space, Duration timeout) noexcept override;
  std::uint64_t overruns() const noexcept override { return batch_.dropped(); }
  bool take_unreachable(Peer& peer) noexcept override { return unreachable_.take(peer); }
  std::uint16_t port() const noexcept override { return port_; }

  // Granted by the system, which may give less than was asked.
  int send_buffer() const noexcept { return send_buffer_; }
  int receive_buffer() const noexcept { return receive_buffer_; }
  // False: what one peer does not take keeps others waiting.
  bool streams_have_queues() const noexcept { return !streams_.empty(); }

 private:
  UdpPort(posix::UdpSocket socket, int family) noexcept
      : socket_(std::move(socket)), family_(family) {}
  // 0 or an errno.
  int configure(const UdpPortOptions& options);
  void hear_refusals(const posix::UdpSocket& socket) const noexcept;
  Status send_by(int fd, const Peer& to, std::span<const std::span<const std::byte>> datagrams,
                 std::size_t& sent) const noexcept;
  Status fill() noexcept;
  Status wait(Duration timeout) noexcept;

  posix::UdpSocket socket_;
  StreamSockets streams_;
  int family_;  // AF_INET6 or AF_INET
  bool refusals_ = false;
  std::uint16_t port_ = 0;
  int send_buffer_ = 0;
  int receive_buffer_ = 0;

  // The receiving thread's.
  posix::DatagramBatch batch_;
  std::size_t read_ = 0;  // datagrams in batch_
  std::size_t next_ = 0;  // of these, to hand out
  UnreachablePeers unreachable_;
};

}  // namespace stof::hal::linux
