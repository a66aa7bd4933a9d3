#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>

#include <sys/socket.h>
#include <sys/uio.h>

#include "hal/datagram_port.h"
#include "hal/linux/open_error.h"
#include "hal/linux/ports/refusals.h"

namespace stof::hal::linux {

struct UdpPortOptions {
  std::uint16_t port = 0;      // 0: any free one
  int buffer_bytes = 4 << 20;  // asked of the system for each direction
  bool ipv4_only = false;      // also where there is IPv6
  int dscp = 0;                // 0 .. 63: class of what is sent (RFC 2474), IPv6 and IPv4
};

// A UDP port at every interface, IPv6 and IPv4 (IPv4 alone where the system has no IPv6), that
// never sends IP fragments. Any thread may send, also several at once; one thread receives and
// takes refusals. An answer "nobody listens there" to an earlier datagram never costs a later one.
class UdpPort final : public hal::DatagramPort {
 public:
  static std::expected<std::unique_ptr<UdpPort>, OpenError> open(const UdpPortOptions& options);
  ~UdpPort() override;
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  Status send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override;
  Result<Received> receive(std::span<std::byte> space, Duration timeout) noexcept override;
  std::uint64_t overruns() const noexcept override {
    return overruns_.load(std::memory_order_relaxed);
  }
  bool take_refusal(Peer& peer) noexcept override { return refusals_.take(peer); }
  std::uint16_t port() const noexcept override { return port_; }

  // Granted by the system, which may give less than was asked.
  int send_buffer() const noexcept { return send_buffer_; }
  int receive_buffer() const noexcept { return receive_buffer_; }

 private:
  static constexpr std::size_t kBatch = 64;
  static constexpr std::size_t kControlSpace = 64;
  static_assert(kControlSpace % alignof(cmsghdr) == 0);

  UdpPort(int fd, int family) noexcept;
  bool configure(const UdpPortOptions& options) noexcept;
  Status send_batch(std::span<mmsghdr> messages, std::size_t& sent) const noexcept;
  Status fill() noexcept;
  Status wait(Duration timeout) noexcept;
  void note_overruns(const msghdr& message) noexcept;

  int fd_;
  int family_;  // AF_INET6 or AF_INET
  std::uint16_t port_ = 0;
  int send_buffer_ = 0;
  int receive_buffer_ = 0;

  // Of the receiving thread.
  std::array<std::array<std::byte, kMaxDatagram>, kBatch> space_;
  alignas(cmsghdr) std::array<std::array<std::byte, kControlSpace>, kBatch> control_;
  std::array<sockaddr_storage, kBatch> from_;
  std::array<iovec, kBatch> vectors_;
  std::array<mmsghdr, kBatch> messages_;
  std::size_t read_ = 0;               // datagrams in space_
  std::size_t next_ = 0;               // of these, to hand out
  std::uint32_t kernel_overruns_ = 0;  // wraps
  Refusals refusals_;
  std::atomic<std::uint64_t> overruns_{0};
};

}  // namespace stof::hal::linux
