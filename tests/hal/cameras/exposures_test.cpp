#include "hal/linux/camera/exposures.h"

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::Time;
using hal::linux::EdgeLog;

TEST(EdgeLog, FindsTheEdgeBeforeAndTheNearest) {
  EdgeLog log;
  EXPECT_EQ(log.at_or_before(Time(1s)), std::nullopt);
  EXPECT_EQ(log.nearest(Time(1s)), std::nullopt);
  for (int i = 1; i <= 200; ++i) {
    log.note(Time(i * 10ms));
  }
  EXPECT_EQ(log.at_or_before(Time(1999ms)), Time(1990ms));
  EXPECT_EQ(log.at_or_before(Time(2000ms)), Time(2000ms));
  EXPECT_EQ(log.nearest(Time(1994ms)), Time(1990ms));
  EXPECT_EQ(log.nearest(Time(1996ms)), Time(2000ms));
  EXPECT_EQ(log.nearest(Time(0ms)), Time(10ms * (201 - static_cast<int>(EdgeLog::kDepth))));
  EXPECT_EQ(log.at_or_before(Time(1ms)), std::nullopt);
}

// As a camera that is opened again while the loop goes on: whatever is told is an edge that went
// out.
TEST(EdgeLog, MayBeLookedAtWhileEdgesAreNoted) {
  EdgeLog log;
  std::atomic<bool> done{false};
  int told = 0;
  std::thread reader([&] {
    do {  // once at least, however late this thread begins
      for (int at = 0; at < 30'000; at += 777) {
        const std::optional<Time> before = log.at_or_before(Time(at * 1ms));
        const std::optional<Time> nearest = log.nearest(Time(at * 1ms));
        told += before || nearest ? 1 : 0;
        ASSERT_TRUE(!before || (*before <= Time(at * 1ms) &&
                                before->time_since_epoch() % 3ms == hal::Duration::zero()));
        ASSERT_TRUE(!nearest || nearest->time_since_epoch() % 3ms == hal::Duration::zero());
      }
    } while (!done.load(std::memory_order_acquire));
  });
  for (int i = 1; i <= 10'000; ++i) {
    log.note(Time(i * 3ms));
    if (i % 100 == 0) {
      std::this_thread::sleep_for(100us);
    }
  }
  done.store(true, std::memory_order_release);
  reader.join();
  EXPECT_GT(told, 0);
}

}  // namespace
}  // namespace stof::test
