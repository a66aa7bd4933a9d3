#include "firmware/loop/device_lending.h"

#include <array>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
using board::Device;
using Need = DeviceLending::Need;

constexpr hal::Time kStart{1000s};

TEST(DeviceLending, ADeviceIsLentWhereItIsLostAndNobodyHoldsItsFrames) {
  DeviceLending lending(false);
  lending.after_round(Device::kStereo, Need::kNone, false, kStart);
  EXPECT_TRUE(lending.usable(Device::kStereo));
  lending.after_round(Device::kStereo, Need::kLost, true, kStart);
  EXPECT_TRUE(lending.usable(Device::kStereo)) << "a frame is borrowed";
  lending.after_round(Device::kStereo, Need::kLost, false, kStart);
  EXPECT_FALSE(lending.usable(Device::kStereo));
  EXPECT_TRUE(lending.usable(Device::kPmd));
  EXPECT_EQ(lending.wait_for_lent(), Device::kStereo);
  lending.give_back(Device::kStereo);
  EXPECT_TRUE(lending.usable(Device::kStereo));
}

// However long a try takes, the next one follows its end.
TEST(DeviceLending, TriesAgainFiftyMillisecondsAfterATryThenLaterAndFourTimesASecond) {
  for (const hal::Duration took : {0ms, 2000ms}) {
    DeviceLending lending(false);
    hal::Time now = kStart;
    std::vector<hal::Duration> waited;
    hal::Time ended = now;
    while (waited.size() < 8) {
      lending.after_round(Device::kPmd, Need::kLost, false, now);
      if (lending.usable(Device::kPmd)) {
        now += 1ms;
        continue;
      }
      waited.push_back(now - ended);
      now += took;
      lending.after_round(Device::kPmd, Need::kLost, false, now);
      EXPECT_FALSE(lending.usable(Device::kPmd)) << "still lent";
      lending.give_back(Device::kPmd);
      ended = now;
    }
    EXPECT_EQ(waited,
              (std::vector<hal::Duration>{0ms, 50ms, 100ms, 200ms, 250ms, 250ms, 250ms, 250ms}));
    // Back, and lost again: soon.
    lending.after_round(Device::kPmd, Need::kNone, false, now);
    now += 250ms;
    lending.after_round(Device::kPmd, Need::kLost, false, now);
    EXPECT_FALSE(lending.usable(Device::kPmd));
  }
}

// Of a camera that repeats itself again soon after it was opened, the pauses go on growing.
TEST(DeviceLending, WhatRepeatsItselfIsLentOnceASecondAtMost) {
  DeviceLending lending(false);
  hal::Time now = kStart;
  std::vector<hal::Duration> waited;
  hal::Time ended = now;
  while (waited.size() < 7) {
    // After each opening it is well for a while.
    const bool well = !waited.empty() && now - ended < 100ms;
    const bool lent =
        lending.after_round(Device::kPmd, well ? Need::kNone : Need::kRepeats, false, now);
    EXPECT_EQ(lent, !lending.usable(Device::kPmd));
    if (lent) {
      waited.push_back(now - ended);
      lending.give_back(Device::kPmd);
      ended = now;
    } else {
      now += 1ms;
    }
  }
  EXPECT_EQ(waited, (std::vector<hal::Duration>{0ms, 250ms, 500ms, 1s, 1s, 1s, 1s}));
  // Lost meanwhile: at once.
  EXPECT_TRUE(lending.after_round(Device::kPmd, Need::kLost, false, now));
  lending.give_back(Device::kPmd);
  // Well for a second after the last pause: at once.
  for (int i = 0; i < 2001; ++i) {
    now += 1ms;
    EXPECT_FALSE(lending.after_round(Device::kPmd, Need::kNone, false, now));
  }
  EXPECT_TRUE(lending.after_round(Device::kPmd, Need::kRepeats, false, now));
  lending.give_back(Device::kPmd);
  now += 1ms;
  EXPECT_FALSE(lending.after_round(Device::kPmd, Need::kRepeats, false, now));
  now += 250ms;
  EXPECT_TRUE(lending.after_round(Device::kPmd, Need::kRepeats, false, now));
}

TEST(DeviceLending, EachDeviceIsLentForItself) {
  DeviceLending lending(false);
  for (const Device device : {Device::kTrigger, Device::kStereo, Device::kPmd}) {
    lending.after_round(device, Need::kLost, false, kStart);
  }
  std::array<bool, board::kDeviceCount> opened{};
  for (std::size_t i = 0; i < board::kDeviceCount; ++i) {
    const Device device = lending.wait_for_lent().value();
    EXPECT_FALSE(std::exchange(opened[static_cast<std::size_t>(device)], true));
    lending.give_back(device);
    EXPECT_TRUE(lending.usable(device));
  }
}

TEST(DeviceLending, TheEndComesBeforeWhatIsLent) {
  DeviceLending lending(false);
  lending.after_round(Device::kStereo, Need::kLost, false, kStart);
  lending.end();
  EXPECT_FALSE(lending.wait_for_lent());
}

TEST(DeviceLending, InEmulatedTimeALentDeviceIsBackAtOnce) {
  DeviceLending lending(true);
  std::thread opener([&] {
    while (const auto device = lending.wait_for_lent()) {
      std::this_thread::sleep_for(1ms);
      lending.give_back(*device);
    }
  });
  for (int i = 0; i < 10; ++i) {
    lending.after_round(Device::kStereo, Need::kLost, false, kStart + i * 1s);
    EXPECT_TRUE(lending.usable(Device::kStereo));
  }
  lending.end();
  opener.join();
}

}  // namespace
}  // namespace stof::firmware
