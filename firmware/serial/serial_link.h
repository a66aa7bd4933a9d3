#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/control/periodic.h"
#include "firmware/serial/byte_ring.h"
#include "firmware/serial/mavlink_reader.h"
#include "firmware/serial/requests.h"
#include "firmware/settings/settings.h"
#include "hal/framing/cobs.h"
#include "hal/serial_port.h"
#include "hal/time.h"

namespace stof::firmware {

// The control thread's side of the serial line. Records of the ring go out, packets in COBS with a
// zero behind them and MAVLink as it is; what comes in is answered. A line that is lost is opened
// again after 50 ms, then after twice as long each time up to a second; what waited is thrown away.
class SerialLink final : public Periodic {
 public:
  // Of any thread.
  struct Counters {
    std::uint64_t sent = 0;     // records and answers that the line took
    std::uint64_t lost = 0;     // that it did not take, being lost or off
    std::uint64_t refused = 0;  // damaged or unknown, of those from the line
  };

  // All of them outlive the link. The port is open, or opens at the first reopen().
  SerialLink(hal::SerialPort& port, ByteRing& ring, LineRequests& requests) noexcept
      : port_(port), ring_(ring), requests_(requests) {}

  // How often tick() has to come so that a driver's queue of 4 KiB never runs dry: 1 to 20 ms.
  static hal::Duration turn(std::uint32_t baud) noexcept;

  // At the next tick; another speed after what the driver may still hold has gone at the old one,
  // so that the answer to whoever asked for it arrives. baud: what the port has at first.
  void set(settings::SerialMode mode, std::uint32_t baud) noexcept;
  void tick(hal::Time now) noexcept override;

  Counters counters() const noexcept;
  bool lost() const noexcept { return lost_.load(std::memory_order_relaxed); }
  // The line stays at the speed it had: it cannot do the one it was told.
  bool baud_refused() const noexcept { return baud_refused_.load(std::memory_order_relaxed); }
  // Of the control thread.
  const mavlink::Autopilot& autopilot() const noexcept { return autopilot_; }

 private:
  static_assert(hal::CobsReader::kMaxFrame == wire::kMaxDatagram);
  using Frame = std::array<std::byte, hal::cobs_bound(wire::kMaxDatagram) + 2>;

  void reopen_when_due(hal::Time now) noexcept;
  void lose(hal::Time now) noexcept;
  void discard() noexcept;
  std::uint64_t discard_ring() noexcept;
  void change_baud(hal::Time now) noexcept;
  void read(hal::Time now) noexcept;
  void take(hal::Time now) noexcept;
  void write(hal::Time now) noexcept;
  bool stage(hal::Time now) noexcept;
  void stage_packet(std::span<const std::byte> packet, hal::Time now) noexcept;
  static void add(std::atomic<std::uint64_t>& counter, std::uint64_t count) noexcept;

  hal::SerialPort& port_;
  ByteRing& ring_;
  LineRequests& requests_;
  settings::SerialMode mode_ = settings::SerialMode::kOff;
  std::uint32_t baud_ = 0;  // 0: as the port is
  std::uint32_t wanted_baud_ = 0;
  bool changing_ = false;
  hal::Time change_at_{};

  Frame staged_{};  // on its way out: [at, size)
  std::size_t staged_at_ = 0;
  std::size_t staged_size_ = 0;
  std::span<const std::byte> answer_;  // waits behind it
  bool quiet_ = true;                  // a zero first: the line's end may be anywhere in a frame
  hal::Time last_write_{};

  wire::DatagramBuffer record_{};
  std::array<std::byte, 512> input_{};
  std::span<const std::byte> unread_;  // of it
  hal::CobsReader packets_;
  mavlink::Reader messages_;
  mavlink::Autopilot autopilot_;

  hal::Duration retry_backoff_{};
  hal::Time retry_at_{};
  std::atomic<bool> lost_ = false;
  std::atomic<bool> baud_refused_ = false;
  std::atomic<std::uint64_t> sent_ = 0;
  std::atomic<std::uint64_t> dropped_ = 0;
  std::atomic<std::uint64_t> refused_ = 0;
};

}  // namespace stof::firmware
