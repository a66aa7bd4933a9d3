#include "host/client/arrival_clock.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <optional>

namespace stof::client {

Duration time_asleep(Duration before) noexcept {
  constexpr int kTries = 4;
  constexpr Duration kTogether = std::chrono::milliseconds(1);
  for (int i = 0; i < kTries; ++i) {
    timespec boot{};
    const Time begin = Time::clock::now();
    if (::clock_gettime(CLOCK_BOOTTIME, &boot) != 0) {
      return before;
    }
    const Time end = Time::clock::now();
    if (end - begin < kTogether) {
      const Duration since_start =
          std::chrono::seconds(boot.tv_sec) + std::chrono::nanoseconds(boot.tv_nsec);
      return std::max(since_start - begin.time_since_epoch(), Duration(0));
    }
  }
  return before;
}

ArrivalClock::Now ArrivalClock::now() noexcept {
  constexpr int kTries = 4;
  constexpr Duration kTogether = std::chrono::milliseconds(1);
  Now now{};
  for (int i = 0; i < kTries; ++i) {
    const Time before = Time::clock::now();
    now.wall = std::chrono::system_clock::now().time_since_epoch();
    now.monotonic = Time::clock::now();
    if (now.monotonic - before < kTogether) {
      break;  // else this thread lost the processor between two clocks
    }
  }
  return now;
}

std::chrono::nanoseconds ArrivalClock::offset() const noexcept {
  return read_.wall - read_.monotonic.time_since_epoch();
}

Time ArrivalClock::arrival(std::chrono::nanoseconds stamp) noexcept {
  std::optional<Time> earliest;
  for (const std::chrono::nanoseconds offset : std::array{offset(), old_offset_}) {
    const Time reading{stamp - offset};
    const bool fits = reading >= earliest_ - kTolerance && reading <= read_.monotonic + kTolerance;
    if (fits && (!earliest || reading < *earliest)) {
      earliest = reading;
    }
  }
  earliest_ =
      std::clamp(earliest.value_or(earliest_), earliest_, std::max(earliest_, read_.monotonic));
  return earliest_;
}

void ArrivalClock::emptied(Time at) noexcept {
  old_offset_ = offset();
  earliest_ = std::max(earliest_, at);
}

}  // namespace stof::client
