#include "hal/linux/system/clock_offset.h"

#include <chrono>

namespace stof::hal::linux {
namespace {
constexpr int kReadings = 5;     // an interrupt spoils one, not five
constexpr int kMostSlew = 1000;  // ppm
}  // namespace

Duration read_clock(clockid_t clock) noexcept {
  timespec at{};
  clock_gettime(clock, &at);  // cannot fail for a clock that the kernel has
  return std::chrono::seconds(at.tv_sec) + std::chrono::nanoseconds(at.tv_nsec);
}

ClockOffset::ClockOffset(clockid_t clock, ClockReader reader) noexcept
    : reader_(reader), clock_(clock) {
  static_cast<void>(measure());
}

bool ClockOffset::measure() noexcept {
  const Duration old_ahead = ahead_;
  const Duration old_measured = measured_;
  const bool first = measured_ == Duration{};
  Duration best = Duration::max();
  for (int i = 0; i < kReadings; ++i) {
    const Duration before = reader_(CLOCK_MONOTONIC);
    const Duration other = reader_(clock_);
    const Duration after = reader_(CLOCK_MONOTONIC);
    if (after >= before && after - before < best) {
      best = after - before;
      ahead_ = other - (before + best / 2);
      measured_ = after;
    }
  }
  uncertainty_ = (best + Duration(1)) / 2;
  if (first) {
    return true;
  }
  const Duration slewed = (measured_ - old_measured) / 1'000'000 * kMostSlew;
  return std::chrono::abs(ahead_ - old_ahead) <= kLeastStep + slewed;
}

}  // namespace stof::hal::linux
