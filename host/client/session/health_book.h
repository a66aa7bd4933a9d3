#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// Which of the reports of health to believe that come in a session's name. They are ordered by the
// uptime, which advances as fast as the time that passes, and a little more. Somebody else's may
// say that all is well while the sensor says stop:
//  - His uptime is ahead, so that the sensor's reports are late. One that comes later than networks
//    turn packets round is told (lies()), and believed where it is as bad as what is known.
//  - His uptime fits. What gets better a second time within 2.5 seconds is believed only when
//    nothing as bad came for 1.2 seconds: a sensor says something once a second.
// So he costs a second. What gets worse is believed at once, however late, and whoever says it.
// Whatever he says, the sensor's next report tells it: each change of the conditions is an event,
// and a report names the newest one. So two reports that name one event agree on what is active, a
// later report names no earlier event, and half a second after an event none names an earlier one.
// No clock: times are the caller's, and never go back.
class HealthBook {
 public:
  enum class Verdict : std::uint8_t {
    kTaken,        // also one that is not believed to be better
    kLate,         // a newer one arrived before
    kImplausible,  // ahead of what any sensor can have counted
  };

  Verdict take(const wire::HealthReport& report, Time arrived);
  // One that the sensor has signed for this receiver: its uptime alone counts.
  Verdict take_signed(const wire::HealthReport& report, Time arrived) noexcept;
  // One that came in the session's name: the first of each sequence.
  void note_event(const wire::EventReport& event, Time arrived) noexcept;
  // A session begins; lies() goes on.
  void restart() noexcept;
  // The clock of arrivals stood for so long.
  void slept(Duration time) noexcept { newest_at_ -= time; }

  const std::optional<wire::HealthReport>& current() const noexcept { return current_; }
  Time at() const noexcept { return current_at_; }  // its arrival; only where there is one
  // How often it was found that two speak, over all sessions.
  std::uint64_t lies() const noexcept { return lies_; }

 private:
  struct Said {
    std::uint64_t uptime_ms = 0;
    Time at{};
  };
  struct Heard {
    wire::EventReport event{};
    Time at{};
  };

  Verdict take_late(const wire::HealthReport& report, Time arrived);
  void hold_against_known(const wire::HealthReport& report, Time arrived) noexcept;
  bool contradicts_event(const wire::HealthReport& report, Time arrived) const noexcept;
  bool believes_uptime(std::uint64_t uptime_ms, Time arrived) const noexcept;
  void show(const wire::HealthReport& report, Time arrived) noexcept;

  std::optional<wire::HealthReport> current_;
  Time current_at_{};
  wire::HealthReport newest_{};  // by its uptime; only where there is a current one
  Time newest_at_{};
  std::optional<Heard> event_;       // the newest
  std::optional<Said> refused_;      // the last one that was not taken
  std::optional<Time> bettered_at_;  // that it got better, or would have
  Time as_bad_at_{};  // the newest one as bad as the current one, also one that is late
  std::uint64_t lies_ = 0;
};

}  // namespace stof::client
