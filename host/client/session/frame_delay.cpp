#include "host/client/session/frame_delay.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr std::int64_t kDriftPpm = 200;  // of two quartz clocks, 100 each
constexpr std::int64_t kMillion = 1'000'000;

// An emulated rig's time has nothing to do with ours.
bool counts(const wire::FrameStamp& stamp) noexcept {
  return stamp.clock == wire::ClockState::kMonotonic;
}

}  // namespace

void FrameDelay::restart() noexcept {
  least_.reset();
  late_since_.reset();
  late_for_ = Duration(0);
}

// A stamp may hold any number.
Duration FrameDelay::difference(const wire::FrameStamp& stamp, Time arrived) const noexcept {
  constexpr std::int64_t kMost = std::int64_t{1} << 61;  // 73 years
  const std::chrono::nanoseconds exposed(std::clamp(stamp.exposure_middle_ns, -kMost, kMost));
  return arrived.time_since_epoch() + slept_ - exposed;
}

// The smallest difference, as the clocks may have drifted since.
Duration FrameDelay::expected(Time arrived) const noexcept {
  const Duration passed = std::max(arrived - least_->at, Duration(0));
  return least_->difference + passed / kMillion * kDriftPpm;
}

void FrameDelay::note(const wire::FrameStamp& stamp, Time arrived, std::uint32_t key,
                      Duration soon) noexcept {
  if (!counts(stamp)) {
    return;
  }
  if (proof_ && proof_->key == key) {
    if (arrived - proof_->asked <= soon) {
      restart();
    }
    proof_.reset();
  }
  const Duration found = difference(stamp, arrived);
  if (!least_ || found <= expected(arrived)) {
    least_ = {.difference = found, .at = arrived};
  }
}

FrameDelay::Verdict FrameDelay::judge(const wire::FrameStamp& stamp, Time arrived, Duration most,
                                      bool is_signed) noexcept {
  if (!counts(stamp) || !least_ || difference(stamp, arrived) - expected(arrived) <= most) {
    late_since_.reset();
    late_for_ = Duration(0);
    return Verdict::kTimely;
  }
  late_since_ = late_since_.value_or(arrived);
  late_for_ = arrived - *late_since_;
  if (is_signed || !held_back()) {
    return Verdict::kLate;
  }
  restart();
  least_ = {.difference = difference(stamp, arrived), .at = arrived};
  return Verdict::kResynchronised;
}

}  // namespace stof::client
