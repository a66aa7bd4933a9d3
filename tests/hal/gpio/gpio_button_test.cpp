#include "hal/linux/gpio/gpio_button.h"

#include <cerrno>

#include <gtest/gtest.h>

#include "tests/hal/gpio/fake_gpiod.h"

namespace stof::hal::linux {
namespace {

class GpioButtonTest : public testing::Test {
 protected:
  test::FakeGpioChip chip_;
};

TEST_F(GpioButtonTest, IsPressedWhileItsLineIsPulledDown) {
  auto button = GpioButton::open({.line = "GPIO2", .devices = chip_.devices()});
  ASSERT_TRUE(button) << button.error().message;
  EXPECT_FALSE(chip_.output[2]);
  EXPECT_TRUE(chip_.pulled_up[2]);
  for (const bool down : {false, true, false}) {
    chip_.high[2] = !down;
    const Result<bool> pressed = (*button)->pressed();
    ASSERT_TRUE(pressed);
    EXPECT_EQ(*pressed, down);
  }
  button->reset();
  EXPECT_EQ(chip_.requests, 0);
}

TEST_F(GpioButtonTest, SaysWhatItCannotHave) {
  const auto none = GpioButton::open({.line = "GPIO99", .devices = chip_.devices()});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("GPIO99"), std::string::npos);
  chip_.request_error = EBUSY;
  const auto taken = GpioButton::open({.line = "GPIO2", .devices = chip_.devices()});
  ASSERT_FALSE(taken);
  EXPECT_NE(taken.error().message.find("gpioinfo"), std::string::npos);
}

TEST_F(GpioButtonTest, SaysThatItCannotBeRead) {
  auto button = GpioButton::open({.line = "GPIO2", .devices = chip_.devices()});
  ASSERT_TRUE(button);
  chip_.value_error = EIO;
  EXPECT_EQ((*button)->pressed().error(), Status::kDeviceError);
  chip_.value_error = ENODEV;
  EXPECT_EQ((*button)->pressed().error(), Status::kDeviceLost);
}

}  // namespace
}  // namespace stof::hal::linux
