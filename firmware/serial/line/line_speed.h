#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

#include "hal/serial_port.h"
#include "hal/time.h"

namespace stof::firmware {

// How long that many bytes take on a line: ten bits each.
constexpr hal::Duration line_time(std::uint64_t bytes, std::uint32_t baud) noexcept {
  constexpr std::uint64_t kTenBitsNs = 10'000'000'000;
  return hal::Duration(static_cast<hal::Duration::rep>(bytes * kTenBitsNs / std::max(baud, 1U)));
}

// The speed of a serial line. A change waits until what the driver may still hold has gone at the
// old speed, so that the answer to whoever asked for it arrives.
class LineSpeed {
 public:
  // The queue of serial drivers: a page.
  static constexpr std::uint32_t kDriverBytes = 4096;
  // Between two ticks.
  static constexpr hal::Duration kLongestTurn = std::chrono::milliseconds(20);

  // The first one is what the port has.
  void want(std::uint32_t baud) noexcept;
  bool changing() const noexcept { return change_at_.has_value(); }
  // The port was lost: the change begins anew once it is back.
  void restart() noexcept { change_at_.reset(); }

  // Begins a change where one is wanted, and carries it out where nothing is on its way any more
  // (`idle`) and it is due. True: the port was asked for it. kDeviceLost of the port.
  Result<bool> tick(hal::SerialPort& port, bool idle, hal::Time now) noexcept;

  // For any thread: the port cannot do the speed wanted last, and keeps the one it had.
  bool refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  std::uint32_t baud_ = 0;  // 0: as the port is
  std::uint32_t wanted_ = 0;
  std::optional<hal::Time> change_at_;
  std::atomic<bool> refused_ = false;
};

}  // namespace stof::firmware
