#include "hal/emu/devices/clock.h"

#include <gtest/gtest.h>

#include "hal/linux/system/clock.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;

TEST(EmuClock, StandsStillUntilSomebodyWaits) {
  hal::emu::Clock clock;
  const hal::Time start = clock.now();
  EXPECT_EQ(clock.now(), start);
  clock.wait_until(start + 5ms);
  EXPECT_EQ(clock.now(), start + 5ms);
}

TEST(EmuClock, NeverGoesBack) {
  hal::emu::Clock clock;
  const hal::Time start = clock.now();
  clock.wait_until(start - 1h);
  EXPECT_EQ(clock.now(), start);
  clock.wait_until(hal::Time::min());
  EXPECT_EQ(clock.now(), start);
}

TEST(PosixClock, NeverGoesBack) {
  hal::linux::Clock clock;
  hal::Time last = clock.now();
  EXPECT_GT(last, hal::Time{});
  for (int i = 0; i < 1000; ++i) {
    const hal::Time now = clock.now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(PosixClock, WaitsAtLeastUntilTheTime) {
  hal::linux::Clock clock;
  for (const hal::Duration wait : {hal::Duration(1ns), hal::Duration(1ms), hal::Duration(3ms)}) {
    const hal::Time until = clock.now() + wait;
    clock.wait_until(until);
    EXPECT_GE(clock.now(), until);
  }
}

TEST(PosixClock, DoesNotWaitForThePast) {
  hal::linux::Clock clock;
  clock.wait_until(clock.now() - 1h);
  clock.wait_until(hal::Time{});
  clock.wait_until(hal::Time::min());
}

}  // namespace
}  // namespace stof::test
