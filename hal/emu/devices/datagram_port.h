#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/datagram_port.h"
#include "hal/emu/devices/faults.h"

namespace stof::hal::emu {

// A port in the process: what is sent waits in a queue for a test or a receiver in the same thread,
// what is received was injected. kWouldBlock when `capacity` datagrams wait. No heap after
// construction. Faults: faults.h; each datagram sent is a call. receive() never blocks.
class DatagramPort final : public hal::DatagramPort {
 public:
  struct Sent {
    Peer to;
    std::span<const std::byte> bytes;
  };

  // capacity: of each direction, datagrams.
  explicit DatagramPort(int capacity, const FaultPlan& faults = {}, std::uint16_t port = 7560);

  Status send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override;
  Result<Received> receive(std::span<std::byte> space, Duration timeout) noexcept override;
  std::uint64_t overruns() const noexcept override { return overruns_; }
  bool take_unreachable(Peer& peer) noexcept override;
  std::uint16_t port() const noexcept override { return port_; }

  // The oldest datagram that was sent, valid until the next call of any function here; none when
  // there is none.
  std::optional<Sent> take_sent() noexcept;
  int waiting() const noexcept { return out_.waiting; }

  // For receive(): bytes beyond kMaxDatagram are kept as a length only. A full queue is an overrun.
  // link: Received::link.
  void inject(std::span<const std::byte> datagram, const Peer& from,
              std::uint32_t link = 0) noexcept;
  // For take_unreachable(); the last one counts.
  void refuse(const Peer& peer) noexcept { refusal_ = peer; }

 private:
  struct Datagram {
    std::array<std::byte, kMaxDatagram> bytes;
    std::size_t size = 0;  // may be more than the space
    Peer peer;
    std::uint32_t link = 0;  // Received::link

    std::span<const std::byte> held() const noexcept;
  };
  struct Queue {
    std::vector<Datagram> ring;
    int first = 0;
    int waiting = 0;

    bool push(const Datagram& datagram) noexcept;
    bool pop(Datagram& datagram) noexcept;
  };
  Status send_one(const Peer& to, std::span<const std::byte> datagram) noexcept;

  Queue out_;
  Queue in_;
  Datagram scratch_{};
  Datagram held_{};  // delayed: goes after the next one
  bool holding_ = false;
  std::optional<Peer> refusal_;
  std::uint64_t overruns_ = 0;
  std::uint16_t port_;
  FaultPlan faults_;
  std::uint32_t calls_ = 0;
};

}  // namespace stof::hal::emu
