#include "board/raspberry_pi.h"

#include <gtest/gtest.h>

#include "hal/linux/libcamera/libcamera_find.h"

// What the tables of all Raspberry Pis have in common.
namespace stof::board {
namespace {

TEST(RaspberryPi, PairIsFoundByWhatLibcameraCallsIt) {
  const std::vector<hal::linux::LibcameraName> cameras{
      {.id = "/base/soc/i2c0mux/i2c@0/imx296@1a", .model = "imx296"},
      {.id = "/base/soc/i2c0mux/i2c@1/imx296@1a", .model = "imx296"}};
  const auto left = hal::linux::find_libcamera(cameras, kPiDevices.libcamera.left);
  const auto right = hal::linux::find_libcamera(cameras, kPiDevices.libcamera.right);
  ASSERT_TRUE(left) << left.error().message;
  ASSERT_TRUE(right) << right.error().message;
  EXPECT_EQ(*left, 0U);
  EXPECT_EQ(*right, 1U);
}

// Exposure = low time + 14.26 us.
TEST(RaspberryPi, XtrIsLowForTheExposureLessWhatTheSensorAdds) {
  EXPECT_TRUE(kPiDevices.libcamera.active_low);
  EXPECT_EQ(pulse_length(kPiDevices.libcamera, std::chrono::milliseconds(4)) +
                std::chrono::nanoseconds(14'260),
            std::chrono::milliseconds(4));
}

TEST(RaspberryPi, APulseOfNothingIsNoTrigger) {
  DeviceConfig devices = kPiDevices;
  EXPECT_TRUE(valid(devices, kPiTiming));
  devices.libcamera.pulse_lag = kPiTiming.stereo_exposure;
  EXPECT_FALSE(valid(devices, kPiTiming));
}

}  // namespace
}  // namespace stof::board
