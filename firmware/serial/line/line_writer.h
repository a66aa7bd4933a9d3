#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/serial/line/byte_ring.h"
#include "firmware/wire/packet.h"
#include "hal/framing/cobs.h"
#include "hal/serial_port.h"
#include "hal/time.h"

namespace stof::firmware {

// Writes to a serial line: an answer first, then the ring's records. Packets in COBS with a
// zero behind them, and one before them where the line was silent; MAVLink as it is.
class LineWriter {
 public:
  // The size of the longest packet on the line.
  static constexpr std::size_t kFrameBytes = hal::cobs_bound(wire::kMaxDatagram) + 2;

  explicit LineWriter(ByteRing& ring) noexcept : ring_(ring) {}

  // Goes next, once; the bytes stay as they are until answering() is false.
  void answer(std::span<const std::byte> packet) noexcept { answer_ = packet; }
  bool answering() const noexcept { return !answer_.empty(); }
  // Nothing is on its way, and no answer waits.
  bool idle() const noexcept { return staged_size_ == 0 && !answering(); }

  // Writes until the port takes no more, a millisecond's work at most. answers_only: records are
  // thrown away. kDeviceLost of the port.
  Status write(hal::SerialPort& port, bool answers_only, hal::Time now) noexcept;
  // Throws away all that waits.
  void discard() noexcept;
  // The other end may be anywhere in a frame: the next packet begins with a zero.
  void begin_anew() noexcept { silent_ = true; }

  // For any thread: records and answers that the line took, and those that were thrown away.
  std::uint64_t sent() const noexcept { return sent_.load(std::memory_order_relaxed); }
  std::uint64_t discarded() const noexcept { return discarded_.load(std::memory_order_relaxed); }

 private:
  bool stage(bool answers_only, hal::Time now) noexcept;
  void stage_packet(std::span<const std::byte> packet, hal::Time now) noexcept;
  std::uint64_t discard_ring() noexcept;

  ByteRing& ring_;
  std::array<std::byte, kFrameBytes> staged_{};  // on its way out: [at, size)
  std::size_t staged_at_ = 0;
  std::size_t staged_size_ = 0;
  std::span<const std::byte> answer_;  // waits behind it
  wire::DatagramBuffer record_{};
  bool silent_ = true;
  hal::Time last_write_{};
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<std::uint64_t> discarded_ = 0;
};

}  // namespace stof::firmware
