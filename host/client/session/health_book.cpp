#include "host/client/session/health_book.h"

#include <algorithm>

#include "firmware/wire/messages/conditions.h"
#include "host/client/frame/frame_slot.h"

namespace stof::client {
namespace {

constexpr std::uint64_t kUptimeSlackMs = 2000;
// Without one that is believed, what was believed may be wrong. One a second is sent.
constexpr Duration kSilence = std::chrono::milliseconds(2500);
// More than a report and the next one are apart.
constexpr Duration kPeriod = std::chrono::milliseconds(1200);
// Between what is better twice: more than two periods.
constexpr Duration kFlaps = std::chrono::milliseconds(2500);
// Networks do not turn round an event and what is sent so much later.
constexpr Duration kEventHolds = 2 * kTurnedRound;

// Whether an uptime follows one that was told at `then`.
bool follows(std::uint64_t uptime_ms, std::uint64_t before_ms, Time then, Time now) noexcept {
  const std::int64_t elapsed_ms = now <= then ? 0 : (now - then) / std::chrono::milliseconds(1);
  const std::uint64_t most = static_cast<std::uint64_t>(elapsed_ms + elapsed_ms / 16);
  return uptime_ms >= before_ms && uptime_ms - before_ms <= most + kUptimeSlackMs;
}

bool better(const wire::HealthReport& one, const wire::HealthReport& other) noexcept {
  return one.reaction != other.reaction ? one.reaction < other.reaction
                                        : one.severity < other.severity;
}

bool same_state(const wire::HealthReport& one, const wire::HealthReport& other) noexcept {
  return one.active == other.active && one.severity == other.severity &&
         one.reaction == other.reaction;
}

// Whether no sensor says both. Two of one millisecond have any order.
bool contradict(const wire::HealthReport& one, const wire::HealthReport& other) noexcept {
  if (one.events == other.events) {
    return one.events != 0 && !same_state(one, other);
  }
  if (one.events == 0 || other.events == 0) {
    return true;
  }
  const bool newer = number_distance(one.events, other.events) > 0;
  return one.uptime_ms != other.uptime_ms && newer != (one.uptime_ms > other.uptime_ms);
}

}  // namespace

HealthBook::Verdict HealthBook::take_signed(const wire::HealthReport& report,
                                            Time arrived) noexcept {
  if (current_ && report.uptime_ms < newest_.uptime_ms) {
    return Verdict::kLate;
  }
  newest_ = report;
  newest_at_ = arrived;
  show(report, arrived);
  return Verdict::kTaken;
}

HealthBook::Verdict HealthBook::take(const wire::HealthReport& report, Time arrived) {
  hold_against_known(report, arrived);
  if (current_ && !believes_uptime(report.uptime_ms, arrived)) {
    const bool late = report.uptime_ms < newest_.uptime_ms;
    refused_ = Said{.uptime_ms = report.uptime_ms, .at = arrived};
    return late ? take_late(report, arrived) : Verdict::kImplausible;
  }
  newest_ = report;
  newest_at_ = arrived;
  refused_.reset();
  if (current_ && better(report, *current_)) {
    const bool flaps = bettered_at_ && arrived - *bettered_at_ < kFlaps;
    bettered_at_ = arrived;
    if (flaps && arrived - as_bad_at_ < kPeriod) {
      return Verdict::kTaken;
    }
  }
  show(report, arrived);
  return Verdict::kTaken;
}

HealthBook::Verdict HealthBook::take_late(const wire::HealthReport& report, Time arrived) {
  constexpr std::uint64_t kMostMs = 10'000;  // more is no more wrong
  const Duration behind =
      std::chrono::milliseconds(std::min(newest_.uptime_ms - report.uptime_ms, kMostMs));
  const bool two_speak = behind + (arrived - newest_at_) >= kTurnedRound;
  lies_ += two_speak ? 1U : 0U;
  as_bad_at_ = better(report, *current_) ? as_bad_at_ : arrived;
  if (better(*current_, report) || (two_speak && !better(report, *current_))) {
    show(report, arrived);
  }
  return Verdict::kLate;
}

bool HealthBook::believes_uptime(std::uint64_t uptime_ms, Time arrived) const noexcept {
  if (follows(uptime_ms, newest_.uptime_ms, newest_at_, arrived)) {
    return true;
  }
  return arrived - newest_at_ >= kSilence && refused_ && uptime_ms > refused_->uptime_ms &&
         follows(uptime_ms, refused_->uptime_ms, refused_->at, arrived);
}

void HealthBook::hold_against_known(const wire::HealthReport& report, Time arrived) noexcept {
  const bool contradicts_report = current_ && contradict(report, newest_);
  if (contradicts_event(report, arrived)) {
    ++lies_;
    event_.reset();  // told: nobody knows whose it is
  } else {
    lies_ += contradicts_report ? 1U : 0U;
  }
}

bool HealthBook::contradicts_event(const wire::HealthReport& report, Time arrived) const noexcept {
  if (!event_ || report.events == 0) {
    return false;
  }
  const wire::EventReport& event = event_->event;
  if (report.events == event.sequence) {
    return event.condition < wire::kConditions &&
           ((report.active >> event.condition) & 1U) != event.active;
  }
  return number_distance(report.events, event.sequence) < 0 && arrived - event_->at >= kEventHolds;
}

void HealthBook::note_event(const wire::EventReport& event, Time arrived) noexcept {
  if (!event_ || number_distance(event.sequence, event_->event.sequence) > 0) {
    event_ = {.event = event, .at = arrived};
  }
}

void HealthBook::show(const wire::HealthReport& report, Time arrived) noexcept {
  as_bad_at_ = arrived;
  current_ = report;
  current_at_ = arrived;
}

void HealthBook::restart() noexcept {
  const std::uint64_t lies = lies_;
  *this = HealthBook();
  lies_ = lies;
}

}  // namespace stof::client
