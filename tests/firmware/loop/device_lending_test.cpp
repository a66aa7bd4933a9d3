#include "firmware/loop/device_lending.h"

#include <array>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
using board::Device;

constexpr hal::Time kStart{1000s};

TEST(DeviceLending, ADeviceIsLentWhereItIsLostAndNobodyHoldsItsFrames) {
  DeviceLending lending(false);
  lending.after_round(Device::kStereo, false, false, kStart);
  EXPECT_TRUE(lending.usable(Device::kStereo));
  lending.after_round(Device::kStereo, true, true, kStart);
  EXPECT_TRUE(lending.usable(Device::kStereo)) << "a frame is borrowed";
  lending.after_round(Device::kStereo, true, false, kStart);
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
      lending.after_round(Device::kPmd, true, false, now);
      if (lending.usable(Device::kPmd)) {
        now += 1ms;
        continue;
      }
      waited.push_back(now - ended);
      now += took;
      lending.after_round(Device::kPmd, true, false, now);
      EXPECT_FALSE(lending.usable(Device::kPmd)) << "still lent";
      lending.give_back(Device::kPmd);
      ended = now;
    }
    EXPECT_EQ(waited,
              (std::vector<hal::Duration>{0ms, 50ms, 100ms, 200ms, 250ms, 250ms, 250ms, 250ms}));
    // Back, and lost again: soon.
    lending.after_round(Device::kPmd, false, false, now);
    now += 250ms;
    lending.after_round(Device::kPmd, true, false, now);
    EXPECT_FALSE(lending.usable(Device::kPmd));
  }
}

TEST(DeviceLending, EachDeviceIsLentForItself) {
  DeviceLending lending(false);
  for (const Device device : {Device::kTrigger, Device::kStereo, Device::kPmd}) {
    lending.after_round(device, true, false, kStart);
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
  lending.after_round(Device::kStereo, true, false, kStart);
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
    lending.after_round(Device::kStereo, true, false, kStart + i * 1s);
    EXPECT_TRUE(lending.usable(Device::kStereo));
  }
  lending.end();
  opener.join();
}

}  // namespace
}  // namespace stof::firmware
