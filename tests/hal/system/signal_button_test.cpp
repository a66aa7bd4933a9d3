#include "hal/linux/system/signal_button.h"

#include <csignal>
#include <thread>

#include <gtest/gtest.h>

namespace stof::hal::linux {
namespace {

TEST(SignalButton, IsPressedForAMomentByOneSignalAndHeldByTheOther) {
  using namespace std::chrono_literals;
  SignalButton button;
  EXPECT_FALSE(button.pressed().value());
  ASSERT_EQ(std::raise(SIGUSR1), 0);
  EXPECT_TRUE(button.pressed().value());
  std::this_thread::sleep_for(400ms);
  EXPECT_FALSE(button.pressed().value());
  ASSERT_EQ(std::raise(SIGUSR2), 0);
  EXPECT_TRUE(button.pressed().value());
  std::this_thread::sleep_for(3100ms);
  EXPECT_TRUE(button.pressed().value());
  std::this_thread::sleep_for(500ms);
  EXPECT_FALSE(button.pressed().value());
  EXPECT_NE(SignalButton::usage().find("kill -USR1 "), std::string::npos);
}

}  // namespace
}  // namespace stof::hal::linux
