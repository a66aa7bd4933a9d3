#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/control/periodic_task.h"
#include "firmware/serial/line/byte_ring.h"
#include "firmware/serial/line/line_reader.h"
#include "firmware/serial/line/line_speed.h"
#include "firmware/serial/line/line_writer.h"
#include "firmware/serial/line/serial_request_handler.h"
#include "firmware/settings/settings.h"
#include "hal/serial_port.h"
#include "hal/time.h"

namespace stof::firmware {

// The control thread's end of the serial line. Records of the ring go out, what comes in is
// answered. A line that is lost is opened again after 50 ms, then after twice as long each time up
// to a second; what waited is thrown away.
class SerialLink final : public PeriodicTask {
 public:
  // For any thread.
  struct Counters {
    std::uint64_t sent = 0;     // records and answers that the line took
    std::uint64_t lost = 0;     // that it did not take, being lost or off
    std::uint64_t refused = 0;  // damaged or unknown, of those from the line
  };

  // All of them outlive the link. The port is open, or opens at the first reopen().
  SerialLink(hal::SerialPort& port, ByteRing& ring, SerialRequestHandler& requests) noexcept
      : port_(port), reader_(requests), writer_(ring) {}

  // How often tick() has to come so that a driver's queue never runs dry: 1 to 20 ms.
  static hal::Duration turn(std::uint32_t baud) noexcept;

  // At the next tick. baud: at first what the port has; another one as LineSpeed says.
  void set(settings::SerialMode mode, std::uint32_t baud) noexcept;
  void tick(hal::Time now) noexcept override;

  Counters counters() const noexcept;
  bool lost() const noexcept { return lost_.load(std::memory_order_relaxed); }
  // The line stays at the speed it had: it cannot do the one that was set.
  bool baud_refused() const noexcept { return speed_.refused(); }
  // For the control thread.
  const mavlink::Autopilot& autopilot() const noexcept { return reader_.autopilot(); }

 private:
  void reopen_when_due(hal::Time now) noexcept;
  // kDeviceLost where the port is.
  Status exchange(hal::Time now) noexcept;
  void lose(hal::Time now) noexcept;

  hal::SerialPort& port_;
  settings::SerialMode mode_ = settings::SerialMode::kOff;
  LineReader reader_;
  LineWriter writer_;
  LineSpeed speed_;
  hal::Duration retry_backoff_{};
  hal::Time retry_at_{};
  std::atomic<bool> lost_ = false;
};

}  // namespace stof::firmware
