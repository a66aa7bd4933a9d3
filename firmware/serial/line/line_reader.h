#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/serial/line/serial_request_handler.h"
#include "firmware/serial/mavlink/mavlink_reader.h"
#include "firmware/settings/settings.h"
#include "hal/framing/cobs.h"
#include "hal/serial_port.h"
#include "hal/time.h"

namespace stof::firmware {

// Reads a serial line: requests in COBS, which are answered, or MAVLink.
class LineReader {
 public:
  explicit LineReader(SerialRequestHandler& requests) noexcept : requests_(requests) {}

  // Reads up to the first request that has an answer, a millisecond's work at most: the answer has
  // to leave before the next request is looked at. Empty: there is none. kDeviceLost of the port.
  Result<std::span<const std::byte>> read(hal::SerialPort& port, settings::SerialMode mode,
                                          hal::Time now) noexcept;
  // Forgets the beginning of a frame that has not ended.
  void reset() noexcept;

  const mavlink::Autopilot& autopilot() const noexcept { return autopilot_; }
  // For any thread: damaged or unknown frames.
  std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  std::span<const std::byte> take(settings::SerialMode mode, hal::Time now) noexcept;

  SerialRequestHandler& requests_;
  std::array<std::byte, 512> input_{};
  std::span<const std::byte> unread_;  // of it
  hal::CobsReader packets_;
  mavlink::Reader messages_;
  mavlink::Autopilot autopilot_;
  std::atomic<std::uint64_t> refused_ = 0;
};

}  // namespace stof::firmware
