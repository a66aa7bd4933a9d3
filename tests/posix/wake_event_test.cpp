#include "posix/wake_event.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace stof::posix {
namespace {

using namespace std::chrono_literals;

TEST(WakeEvent, WakesOnceHoweverOftenItWasWoken) {
  const WakeEvent event;
  ASSERT_TRUE(event.works());
  EXPECT_FALSE(event.wait(0ms));
  event.wake();
  event.wake();
  EXPECT_TRUE(event.wait(0ms));
  EXPECT_FALSE(event.wait(1ms));
}

TEST(WakeEvent, WakesAThreadThatWaits) {
  const WakeEvent event;
  std::thread other([&] {
    std::this_thread::sleep_for(2ms);
    event.wake();
  });
  EXPECT_TRUE(event.wait(60s));
  other.join();
}

}  // namespace
}  // namespace stof::posix
