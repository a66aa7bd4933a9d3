#include "host/client/session/health_book.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr std::uint64_t kUptimeSlackMs = 2000;
// Without one that is believed, what was believed may be wrong. One a second is sent.
constexpr Duration kSilence = std::chrono::milliseconds(2500);
// More than a report and the next one are apart.
constexpr Duration kPeriod = std::chrono::milliseconds(1200);
// Between what is better twice: more than two periods.
constexpr Duration kFlaps = std::chrono::milliseconds(2500);
// Networks do not turn round packets that were sent farther apart.
constexpr Duration kTurnedRound = std::chrono::milliseconds(250);
// Where what heals is lost or late, a report is worse than the frames behind it; hardly ever three.
constexpr Duration kRefutalWindow = std::chrono::seconds(8);
constexpr int kMostRefutals = 2;

// Whether an uptime follows one that was told at `then`.
bool follows(std::uint64_t uptime_ms, std::uint64_t before_ms, Time then, Time now) noexcept {
  const std::int64_t elapsed_ms = now <= then ? 0 : (now - then) / std::chrono::milliseconds(1);
  const std::uint64_t most = static_cast<std::uint64_t>(elapsed_ms + elapsed_ms / 16);
  return uptime_ms >= before_ms && uptime_ms - before_ms <= most + kUptimeSlackMs;
}

// What a frame says of a sensor that reports this.
wire::Health summary(const wire::HealthReport& report) noexcept {
  switch (report.severity) {
    case wire::Severity::kCritical:
      return wire::Health::kFault;
    case wire::Severity::kInfo:
      return wire::Health::kOk;
    default:
      return wire::Health::kDegraded;
  }
}

bool better(const wire::HealthReport& one, const wire::HealthReport& other) noexcept {
  return one.reaction != other.reaction ? one.reaction < other.reaction
                                        : one.severity < other.severity;
}

}  // namespace

HealthBook::Verdict HealthBook::take_signed(const wire::HealthReport& report,
                                            Time arrived) noexcept {
  if (current_ && report.uptime_ms < newest_.uptime_ms) {
    return Verdict::kLate;
  }
  newest_ = {.uptime_ms = report.uptime_ms, .at = arrived};
  show(report, arrived);
  return Verdict::kTaken;
}

HealthBook::Verdict HealthBook::take(const wire::HealthReport& report, Time arrived) {
  hold_against_frames(report, arrived);
  if (current_ && !believes_uptime(report.uptime_ms, arrived)) {
    const bool late = report.uptime_ms < newest_.uptime_ms;
    refused_ = Said{.uptime_ms = report.uptime_ms, .at = arrived};
    return late ? take_late(report, arrived) : Verdict::kImplausible;
  }
  newest_ = {.uptime_ms = report.uptime_ms, .at = arrived};
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
  const bool two_speak = behind + (arrived - newest_.at) >= kTurnedRound;
  lies_ += two_speak ? 1U : 0U;
  as_bad_at_ = better(report, *current_) ? as_bad_at_ : arrived;
  if (better(*current_, report) || (two_speak && !better(report, *current_))) {
    show(report, arrived);
  }
  return Verdict::kLate;
}

bool HealthBook::believes_uptime(std::uint64_t uptime_ms, Time arrived) const noexcept {
  if (follows(uptime_ms, newest_.uptime_ms, newest_.at, arrived)) {
    return true;
  }
  return arrived - newest_.at >= kSilence && refused_ && uptime_ms > refused_->uptime_ms &&
         follows(uptime_ms, refused_->uptime_ms, refused_->at, arrived);
}

void HealthBook::hold_against_frames(const wire::HealthReport& report, Time arrived) noexcept {
  if (!refuted_ || summary(report) == wire::Health::kOk) {
    return;
  }
  refuted_ = false;
  if (!first_refuted_at_ || arrived - *first_refuted_at_ > kRefutalWindow) {
    first_refuted_at_ = arrived;
    refutals_ = 0;
  }
  lies_ += ++refutals_ > kMostRefutals ? 1U : 0U;
}

void HealthBook::note_frame(wire::Health health, Time arrived) noexcept {
  const wire::Health said = current_ ? summary(*current_) : wire::Health::kOk;
  if (said == wire::Health::kOk) {
    return;
  }
  if (health >= said) {
    better_since_.reset();
    refuted_ = false;
    refutals_ = 0;
  } else if (arrived - as_bad_since_ >= kTurnedRound) {
    better_since_ = better_since_.value_or(arrived);
    refuted_ = arrived - *better_since_ >= kTurnedRound;
  }
}

void HealthBook::show(const wire::HealthReport& report, Time arrived) noexcept {
  if (!current_ || summary(report) > summary(*current_)) {
    as_bad_since_ = arrived;
    better_since_.reset();
  }
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
