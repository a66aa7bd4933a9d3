#include "host/bridge/exposure_clock.h"

#include <algorithm>

namespace stof::bridge {
namespace {

constexpr std::int64_t kMillion = 1'000'000;
constexpr std::int64_t kMostNs = std::int64_t{1} << 61;  // 73 years: sums stay in range
constexpr std::int64_t kMostLatencyNs = 10'000'000'000;

}  // namespace

std::int64_t ExposureClock::drift_since(std::int64_t at_ns) const noexcept {
  return std::max<std::int64_t>(at_ns - least_->at_ns, 0) / kMillion * kDriftPpm;
}

void ExposureClock::note_difference(std::int64_t difference_ns, std::int64_t at_ns) noexcept {
  const auto expected = [&] { return least_->difference_ns + drift_since(at_ns); };
  if (!least_ || difference_ns <= expected()) {
    least_ = {.difference_ns = difference_ns, .at_ns = at_ns};
  }
  if (difference_ns - expected() <= kStepNs) {
    late_since_ns_.reset();
    return;
  }
  late_since_ns_ = late_since_ns_.value_or(at_ns);
  if (at_ns - *late_since_ns_ >= kPatienceNs) {
    least_ = {.difference_ns = difference_ns, .at_ns = at_ns};
    late_since_ns_.reset();
  }
}

ExposureClock::Exposure ExposureClock::note(const Arrival& arrival) noexcept {
  if (session_ != arrival.session) {
    session_ = arrival.session;
    least_.reset();
    late_since_ns_.reset();
    latency_ns_ = 0;
  }
  const std::int64_t at = std::clamp(arrival.at_ns, -kMostNs, kMostNs);
  const std::int64_t exposed = std::clamp(arrival.stamp.exposure_middle_ns, -kMostNs, kMostNs);
  if (arrival.latency_ns) {
    latency_ns_ = std::clamp<std::int64_t>(*arrival.latency_ns, 0, kMostLatencyNs);
  }
  if (arrival.stamp.clock != wire::ClockState::kMonotonic) {
    return {.middle_ns = at - latency_ns_};
  }
  if (arrival.latency_ns) {
    note_difference(at - latency_ns_ - exposed, at);
  }
  if (!least_) {
    return {.middle_ns = at};
  }
  const std::int64_t drift = drift_since(at);
  Exposure exposure{.middle_ns = exposed + least_->difference_ns + drift};
  if (arrival.round_trip_ns) {
    exposure.bound_ns = std::clamp<std::int64_t>(*arrival.round_trip_ns, 0, kMostNs) + 2 * drift;
  }
  return exposure;
}

}  // namespace stof::bridge
