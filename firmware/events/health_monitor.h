#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/events/events.h"
#include "firmware/wire/messages/conditions.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "hal/time.h"

namespace stof::firmware {

// The control thread's state, for health messages of the loop.
struct ControlStatus {
  wire::ControlCounters requests{};
  std::uint64_t serial_sent = 0;
  std::uint64_t serial_dropped = 0;
  std::uint64_t serial_refused = 0;
  std::uint32_t settings_revision = 0;
  std::uint8_t subscribers = 0;
  bool serial_lost = false;
  bool settings_unsaved = false;
  bool settings_fell_back = false;
  bool restart_needed = false;
};

// Which conditions (docs/WIRE.md, "Events") are active, and what has to be sent about them: each
// change at once and once more a second later, the whole once a second and on change. For the
// loop's thread; no heap.
class HealthMonitor {
 public:
  explicit HealthMonitor(hal::Time start) noexcept : start_(start), second_(start) {}

  // Takes an event that the loop noted.
  void observe(const Event& event) noexcept;
  void set(wire::Condition condition, bool active, std::uint32_t value, hal::Time now) noexcept;
  void frame_sent(hal::Duration latency, bool drifted, std::uint32_t drifts,
                  hal::Time now) noexcept;

  // The health that the active conditions make.
  wire::Health summary() const noexcept;

  // The next message of each kind that is due, health also where it is wanted; call until there is
  // none.
  std::optional<wire::EventReport> next_event(hal::Time now) noexcept;
  std::optional<wire::HealthReport> next_health(const Counters& counters,
                                                const ControlStatus& control, bool wanted,
                                                hal::Time now) noexcept;
  // The rate of the last whole second, 1/1000 Hz.
  std::uint32_t rate_millihertz() const noexcept { return rate_millihertz_; }

 private:
  struct Entry {
    bool active = false;
    bool changed = false;  // to be sent
    bool again = false;    // to be sent once more
    std::uint32_t count = 0;
    std::uint32_t value = 0;
    std::uint32_t sequence = 0;
    hal::Time at{};
  };

  // Begins and ends the conditions of a camera that is there.
  void observe_supply(const Event& event) noexcept;
  wire::EventReport report(std::size_t condition) const noexcept;
  void judge_second(const Counters& counters, const ControlStatus& control, hal::Time now) noexcept;

  hal::Time start_;
  std::array<Entry, wire::kConditions> entries_{};
  std::uint32_t sequence_ = 0;
  bool changed_ = true;

  hal::Time second_;  // begin of the one that runs
  std::uint32_t frames_ = 0;
  hal::Duration latency_{};
  hal::Duration longest_{};
  std::uint32_t rate_millihertz_ = 0;
  std::uint32_t latency_us_ = 0;
  std::uint32_t longest_us_ = 0;
  std::uint64_t dropped_ = 0;  // counters as they were at its begin
  std::uint64_t serial_dropped_ = 0;
  std::uint64_t refused_ = 0;
};

// As they travel; held to 0 .. 2^32 - 1.
std::uint32_t microseconds(hal::Duration time) noexcept;
wire::LoopCounters loop_counters(const Counters& counters) noexcept;

}  // namespace stof::firmware
