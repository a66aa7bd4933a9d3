#include <gtest/gtest.h>

#include "board/board.h"
#include "hal/linux/libcamera/libcamera_find.h"

// The table of a board with a Raspberry Pi's connectors.
namespace stof::board {
namespace {

constexpr const DeviceConfig& kDevices = kConfig.devices;

TEST(Table, PairIsFoundByWhatLibcameraCallsIt) {
  const std::vector<hal::linux::LibcameraName> cameras{
      {.id = "/base/soc/i2c0mux/i2c@0/imx296@1a", .model = "imx296"},
      {.id = "/base/soc/i2c0mux/i2c@1/imx296@1a", .model = "imx296"}};
  const auto left = hal::linux::find_libcamera(cameras, kDevices.libcamera.left);
  const auto right = hal::linux::find_libcamera(cameras, kDevices.libcamera.right);
  ASSERT_TRUE(left) << left.error().message;
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_EQ(*left, 0U);
  EXPECT_EQ(*right, 1U);
}

// Exposure = low time + 14.26 us.
TEST(Table, XtrIsLowForTheExposureLessWhatTheSensorAdds) {
  EXPECT_TRUE(kDevices.libcamera.active_low);
  EXPECT_EQ(pulse_length(kDevices.libcamera, std::chrono::milliseconds(4)) +
                std::chrono::nanoseconds(14'260),
            std::chrono::milliseconds(4));
}

TEST(Table, FramesAreStampedByWhatIsMoreUrgent) { EXPECT_LT(kDevices.priority, 50); }

TEST(Table, WhatDoesNotFitIsNoBoard) {
  Config config = kConfig;
  EXPECT_TRUE(valid(config));
  config.devices.v4l2.most_delay = config.timing.period;
  EXPECT_FALSE(valid(config)) << "stamps of two edges mix";
  config = kConfig;
  config.devices.watchdog_timeout = 2 * config.timing.period;
  EXPECT_FALSE(valid(config));
  config = kConfig;
  config.devices.pmd.edge_tolerance = config.timing.period / 2;
  EXPECT_FALSE(valid(config));
  config = kConfig;
  config.devices.libcamera.pulse_lag = config.timing.stereo_exposure;
  EXPECT_FALSE(valid(config)) << "no pulse";
}

}  // namespace
}  // namespace stof::board
