#pragma once

#include <ctime>

#include "hal/time.h"

namespace stof::hal::linux {

// Time of another clock of this machine, since its own beginning.
using ClockReader = Duration (*)(clockid_t clock) noexcept;
// clock_gettime(2).
Duration read_clock(clockid_t clock) noexcept;

// Stamps of CLOCK_BOOTTIME or CLOCK_REALTIME on hal::Time, and back. CLOCK_BOOTTIME leaps when the
// machine has slept, CLOCK_REALTIME is slewed (500 ppm, adjtimex(2)) and set: measure() before
// stamps are converted, which takes about a microsecond. For one thread.
class ClockOffset {
 public:
  // Measurements that differ by more than this, and by 1000 ppm of the time between them, are a
  // step and not a slew.
  static constexpr Duration kLeastStep = std::chrono::milliseconds(1);

  // Measures.
  explicit ClockOffset(clockid_t clock, ClockReader reader = read_clock) noexcept;

  // Again. Reads the clock between two readings of CLOCK_MONOTONIC, several times, and keeps the
  // closest. False: the clock was stepped since the last time, and stamps from before the step
  // convert wrongly.
  bool measure() noexcept;

  // `stamp`: of the other clock, since its beginning.
  Time to_monotonic(Duration stamp) const noexcept { return Time(stamp - ahead_); }
  Duration from_monotonic(Time time) const noexcept { return time.time_since_epoch() + ahead_; }
  // Both are right to within this, at the time of the measurement.
  Duration uncertainty() const noexcept { return uncertainty_; }

 private:
  ClockReader reader_;
  clockid_t clock_;
  Duration ahead_{};  // of CLOCK_MONOTONIC
  Duration uncertainty_{};
  Duration measured_{};  // when
};

}  // namespace stof::hal::linux
