#include "host/picture/colour_scale.h"

#include <cstdlib>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

int difference(const Rgb& a, const Rgb& b) {
  return std::abs(a.red - b.red) + std::abs(a.green - b.green) + std::abs(a.blue - b.blue);
}

TEST(ColourScale, IsWarmNearAndColdFar) {
  const ColourScale scale{.near_m = 1, .far_m = 8};
  const Rgb near = scale.colour(1.1);
  const Rgb far = scale.colour(7.5);
  EXPECT_GT(near.red, near.blue + 80);
  EXPECT_GT(far.blue, far.red + 40);
}

TEST(ColourScale, GivesADistanceOneColourAndClampsBeyondItsEnds) {
  const ColourScale scale{.near_m = 0.5, .far_m = 4};
  EXPECT_EQ(scale.colour(0.5), scale_colour(0));
  EXPECT_EQ(scale.colour(0.01), scale_colour(0));
  EXPECT_EQ(scale.colour(4), scale_colour(1));
  EXPECT_EQ(scale.colour(100), scale_colour(1));
  EXPECT_DOUBLE_EQ(scale.position(1), 1.0 / 3);  // log2(1 / 0.5) of log2(4 / 0.5)
}

TEST(ColourScale, ChangesEverywhereAndNeverJumps) {
  for (int i = 0; i < 256; ++i) {
    const int step = difference(scale_colour(i / 256.0), scale_colour((i + 1) / 256.0));
    EXPECT_LE(step, 24) << i;
  }
  for (int i = 0; i < 20; ++i) {
    EXPECT_GE(difference(scale_colour(i / 20.0), scale_colour((i + 1) / 20.0)), 12) << i;
  }
}

TEST(ColourScale, HasRoundDistancesAsTicks) {
  EXPECT_EQ((ColourScale{.near_m = 1, .far_m = 8}).ticks(),
            (std::vector<double>{1, 1.5, 2, 3, 5, 7}));
  EXPECT_EQ((ColourScale{.near_m = 6, .far_m = 20}).ticks(), (std::vector<double>{7, 10, 15, 20}));
  // Only 2 is one of those.
  const std::vector<double> narrow = ColourScale{.near_m = 1.61, .far_m = 2.9}.ticks();
  ASSERT_EQ(narrow.size(), 6U);
  EXPECT_NEAR(narrow.front(), 1.8, 1e-12);
  EXPECT_NEAR(narrow.back(), 2.8, 1e-12);
}

TEST(RoundTicks, AreRoundAndWithin) {
  EXPECT_EQ(round_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(round_ticks(-1.1, 1.1, 4), (std::vector<double>{-1, 0, 1}));
  const std::vector<double> small = round_ticks(0.031, 0.0495, 4);
  ASSERT_EQ(small.size(), 3U);
  EXPECT_NEAR(small[0], 0.035, 1e-12);
  EXPECT_NEAR(small[2], 0.045, 1e-12);
}

}  // namespace
}  // namespace stof::host
