#include "dsp/base/fixed.h"

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

TEST(Fixed, RoundShiftRoundsHalvesUp) {
  EXPECT_EQ(round_shift(7, 3), 1);
  EXPECT_EQ(round_shift(4, 3), 1);
  EXPECT_EQ(round_shift(3, 3), 0);
  EXPECT_EQ(round_shift(-4, 3), 0);
  EXPECT_EQ(round_shift(-5, 3), -1);
}

TEST(Fixed, DisparityNoneIsNoDisparity) {
  EXPECT_FALSE(Disparity::none().valid());
  EXPECT_FALSE(Disparity{}.valid());
  EXPECT_TRUE(Disparity::from_pixels(0).valid());
  EXPECT_EQ(Disparity::from_pixels(-3).raw, -48);
  EXPECT_FLOAT_EQ(Disparity::from_raw(24).pixels(), 1.5F);
}

}  // namespace
}  // namespace stof::dsp
