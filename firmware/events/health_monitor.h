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
  std::uint32_t settings_dropped = 0;     // of the condition; 0: not
  std::uint32_t connection_replaced = 0;  // likewise
  std::uint32_t calibration_dropped = 0;  // likewise
  std::uint8_t subscribers = 0;
  bool serial_lost = false;
  bool settings_unsaved = false;
  bool settings_fell_back = false;
  bool restart_needed = false;
  std::uint32_t release = 0;  // kRelease... of event_values.h
  std::uint32_t release_fingerprint = 0;
  bool keep_awake = false;  // frames shall prove something: no standby
  bool unpaired = false;
  bool keys_lost = false;
};

// Which conditions (docs/WIRE.md, "Events") are active, and what has to be sent about them: each
// change at once, also where several of one condition come at once, the last of them once more a
// second later, the whole once a second and on change. For the
// loop's thread; no heap.
class HealthMonitor {
 public:
  // Why there is no depth, the sum: the value of the condition.
  enum Blindness : std::uint32_t { kNoCoverage = 1, kNoDepthStream = 2, kShortRange = 4 };

  explicit HealthMonitor(hal::Time start) noexcept : start_(start), sums_{.begin = start} {}

  // Takes an event that the loop noted.
  void observe(const Event& event) noexcept;
  void set(wire::Condition condition, bool active, std::uint32_t value, hal::Time now) noexcept;
  void frame_sent(hal::Duration latency, bool drifted, std::uint32_t drifts,
                  hal::Time now) noexcept;
  // Of a frame: its pixels, and those that have a depth.
  void note_coverage(std::uint64_t pixels, std::uint64_t with_depth) noexcept {
    sums_.pixels += pixels;
    sums_.with_depth += with_depth;
  }
  // Of a frame of the pair: its pixels, and those whose depth stands on a match.
  void note_matches(std::uint64_t pixels, std::uint64_t matched) noexcept {
    sums_.of_pair += pixels;
    sums_.matched += matched;
  }
  // Somebody is new who may not have heard what came of the newest trial: that event is sent once
  // more.
  void tell_release_again() noexcept;
  // What of the settings makes the sensor blind: Blindness, the sum.
  void note_blinding(std::uint32_t by_settings, hal::Time now) noexcept;

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
    std::uint32_t former = 0;
    std::uint32_t sequence = 0;
    hal::Time at{};
  };

  // Since `begin`, for what only a whole second can tell.
  struct Sums {
    hal::Time begin{};
    std::uint32_t frames = 0;
    hal::Duration latency{};
    hal::Duration longest{};
    std::uint64_t pixels = 0;
    std::uint64_t with_depth = 0;
    std::uint64_t of_pair = 0;  // pixels
    std::uint64_t matched = 0;  // of these
    std::uint64_t dropped = 0;  // counters as they were at its begin, as the next two
    std::uint64_t serial_dropped = 0;
    std::uint64_t refused = 0;
  };

  // Begins a condition, once more where it is active.
  void begin(wire::Condition condition, std::uint32_t value, hal::Time now) noexcept;
  void change(Entry& entry, bool active, std::uint32_t value, hal::Time now) noexcept;
  void set_blindness(std::uint32_t blindness, hal::Time now) noexcept;
  void judge_coverage(hal::Time now) noexcept;
  void judge_matches(hal::Time now) noexcept;
  // Begins and ends the conditions of a camera that is there.
  void observe_supply(const Event& event) noexcept;
  void observe_release(const Event& event) noexcept;
  wire::EventReport report(std::size_t condition) const noexcept;
  void set_recent(wire::Condition condition, hal::Time now) noexcept;
  void judge_second(const Counters& counters, const ControlStatus& control, hal::Time now) noexcept;

  hal::Time start_;
  std::array<Entry, wire::kConditions> entries_{};
  std::uint32_t sequence_ = 1;  // of the newest event; health has it, where 0 is none
  bool changed_ = true;
  // Changes of a condition that has changed again since; what does not fit is missing in the
  // sequence.
  SpscRing<wire::EventReport, 32> earlier_;

  Sums sums_;                    // of the second that runs
  std::uint32_t blindness_ = 0;  // the sum
  std::uint32_t rate_millihertz_ = 0;
  std::uint32_t latency_us_ = 0;
  std::uint32_t longest_us_ = 0;
};

// As they travel; held to 0 .. 2^32 - 1.
std::uint32_t microseconds(hal::Duration time) noexcept;
wire::LoopCounters loop_counters(const Counters& counters) noexcept;

}  // namespace stof::firmware
