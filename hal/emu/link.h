#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/emu/faults.h"
#include "hal/link.h"

namespace stof::hal::emu {

// A datagram queue in the process: the loop sends, a test or a receiver in the same thread reads.
// kWouldBlock when `capacity` datagrams wait. No heap after construction. Faults: faults.h.
class Link final : public hal::Link {
 public:
  explicit Link(int capacity, const FaultPlan& faults = {});

  Status send(std::span<const std::byte> datagram) noexcept override;

  // The oldest datagram, valid until the next call of any function here; none when empty.
  std::optional<std::span<const std::byte>> receive() noexcept;
  int waiting() const noexcept { return waiting_; }

 private:
  struct Datagram {
    std::array<std::byte, kMaxDatagram> bytes;
    std::size_t size = 0;
  };
  bool push(const Datagram& datagram) noexcept;

  std::vector<Datagram> queue_;  // a ring
  int first_ = 0;
  int waiting_ = 0;
  Datagram scratch_{};
  Datagram held_{};  // delayed: goes after the next one
  bool holding_ = false;
  FaultPlan faults_;
  std::uint32_t calls_ = 0;
};

}  // namespace stof::hal::emu
