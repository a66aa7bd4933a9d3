#include "hal/linux/system/clock.h"

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace stof::hal::linux {
namespace {
constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
}  // namespace

Time Clock::now() noexcept {
  timespec at{};
  clock_gettime(CLOCK_MONOTONIC, &at);  // cannot fail for this clock
  return Time(std::chrono::seconds(at.tv_sec) + std::chrono::nanoseconds(at.tv_nsec));
}

void Clock::wait_until(Time time) noexcept {
  const std::int64_t nanoseconds = time.time_since_epoch().count();
  if (nanoseconds <= 0) {
    return;
  }
  timespec until{};
  until.tv_sec = static_cast<time_t>(nanoseconds / kNanosecondsPerSecond);
  until.tv_nsec = static_cast<long>(
      nanoseconds % kNanosecondsPerSecond);  // NOLINT(google-runtime-int): timespec's
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace stof::hal::linux
