#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/emu/devices/faults.h"
#include "hal/serial_port.h"

namespace stof::hal::emu {

// A serial line in the process: what the appliance writes the other end take()s, what the other end
// feed()s the appliance reads. Each direction holds `capacity` bytes. No heap after construction.
//
// Faults strike at a write(), by its number:
//   kDrop     taken, and lost on the way
//   kDelay    nothing is taken, as by a full queue
//   kTear     half of it is taken
//   kRepeat   its last byte arrives twice
//   kCorrupt  its middle byte arrives changed
//   kVanish   kDeviceLost, from now on from every call until a reopen() that no fault strikes
class SerialPort final : public hal::SerialPort {
 public:
  SerialPort(std::size_t capacity, std::uint32_t baud, const FaultPlan& faults = {});

  Result<std::size_t> write(std::span<const std::byte> bytes) noexcept override;
  Result<std::size_t> read(std::span<std::byte> space) noexcept override;
  // kUnsupported: 0.
  Status set_baud(std::uint32_t baud) noexcept override;
  // Counts as a call like write().
  Status reopen() noexcept override;

  // The other end sends; bytes that do not fit are lost.
  void feed(std::span<const std::byte> bytes) noexcept;
  std::size_t take(std::span<std::byte> space) noexcept;
  std::size_t waiting() const noexcept { return out_.size; }
  std::uint32_t baud() const noexcept { return baud_; }
  std::uint32_t calls() const noexcept { return calls_; }
  bool lost() const noexcept { return lost_; }

 private:
  struct Queue {
    std::vector<std::byte> bytes;  // a ring
    std::size_t first = 0;
    std::size_t size = 0;

    std::size_t room() const noexcept { return bytes.size() - size; }
    void push(std::byte value) noexcept;  // only where there is room
    std::size_t pop(std::span<std::byte> space) noexcept;
  };

  Queue out_;
  Queue in_;
  std::uint32_t baud_;
  bool lost_ = false;
  FaultPlan faults_;
  std::uint32_t calls_ = 0;
};

}  // namespace stof::hal::emu
