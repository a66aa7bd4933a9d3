#include "hal/linux/system/signal_button.h"

#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>

namespace stof::hal::linux {
namespace {

using namespace std::chrono_literals;

Time now{1000s};

TEST(SignalButton, IsPressedForAMomentByOneSignalAndHeldByTheOther) {
  SignalButton button([]() noexcept { return now; });
  EXPECT_FALSE(button.pressed().value());
  ASSERT_EQ(std::raise(SIGUSR1), 0);
  EXPECT_TRUE(button.pressed().value());
  now += 299ms;
  EXPECT_TRUE(button.pressed().value());
  now += 1ms;
  EXPECT_FALSE(button.pressed().value());
  ASSERT_EQ(std::raise(SIGUSR2), 0);
  EXPECT_TRUE(button.pressed().value());
  now += 5999ms;
  EXPECT_TRUE(button.pressed().value());
  now += 1ms;
  EXPECT_FALSE(button.pressed().value());
}

TEST(SignalButton, ASignalThatFindsItPressedLetsItGoBefore) {
  SignalButton button([]() noexcept { return now; });
  now += 10s;
  ASSERT_EQ(std::raise(SIGUSR2), 0);
  EXPECT_TRUE(button.pressed().value());
  now += 3s;
  ASSERT_EQ(std::raise(SIGUSR2), 0);
  EXPECT_FALSE(button.pressed().value());
  now += 999ms;
  EXPECT_FALSE(button.pressed().value());
  now += 1ms;
  EXPECT_TRUE(button.pressed().value());
  now += 5999ms;
  EXPECT_TRUE(button.pressed().value());
  now += 1ms;
  EXPECT_FALSE(button.pressed().value());
}

TEST(SignalButton, ItsTimePassesByItself) {
  SignalButton button;
  ASSERT_EQ(std::raise(SIGUSR1), 0);
  const auto seen = std::chrono::steady_clock::now();
  const auto end = seen + 60s;
  while (button.pressed().value() && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_FALSE(button.pressed().value());
  EXPECT_GE(std::chrono::steady_clock::now() - seen, 299ms);
  EXPECT_NE(SignalButton::usage().find("kill -USR1 "), std::string::npos);
}

}  // namespace
}  // namespace stof::hal::linux
