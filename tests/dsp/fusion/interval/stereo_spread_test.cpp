#include "dsp/fusion/interval/stereo_spread.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr SpreadTable kSteps{4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 56, 64, 100, 150, 200, 255};

int spread_of(Disparity disparity, std::uint8_t ratio, std::int16_t infinity = -16384) {
  std::uint8_t half = 9;
  ref::stereo_spread({&disparity, 1}, {&ratio, 1}, kSteps, infinity, {&half, 1});
  return half;
}

TEST(StereoSpread, IsTheTablesStepOfTheRatio) {
  for (int ratio = 0; ratio < 256; ++ratio) {
    EXPECT_EQ(spread_of(Disparity::from_pixels(60), static_cast<std::uint8_t>(ratio)),
              kSteps[static_cast<std::size_t>(ratio / 16)]);
  }
}

TEST(StereoSpread, IsAtMostAnEighthOfTheParallax) {
  EXPECT_EQ(spread_of(Disparity::from_pixels(10), 255, 0), 20);
  EXPECT_EQ(spread_of(Disparity::from_pixels(10), 255, -160), 40);
  EXPECT_EQ(spread_of(Disparity::from_pixels(10), 255, 16), 18);
  EXPECT_EQ(spread_of(Disparity::from_pixels(1), 255, 0), kLeastSpread);
  EXPECT_EQ(spread_of(Disparity::from_pixels(-3), 255, 0), kLeastSpread);  // behind infinity
}

TEST(StereoSpread, OfNoDisparityIsNone) { EXPECT_EQ(spread_of(Disparity::none(), 255), 0); }

TEST(StereoSpread, TablesNeverFallWithTheRatio) {
  for (const SpreadTable& table : {kBlockSpread, kPathSpread}) {
    EXPECT_TRUE(std::ranges::is_sorted(table));
    EXPECT_GE(table.front(), kLeastSpread);
  }
}

TEST(StereoSpread, NeonEqualsReferenceForEveryLengthAndAnyDisparity) {
  for (std::size_t n = 0; n <= 70; ++n) {
    for (const int infinity : {-16384, -640, 0, 333, 16384}) {
      test::Random random(n + static_cast<std::size_t>(infinity + 16384));
      test::GuardedBuffer<Disparity> disparity(n);
      test::GuardedBuffer<std::uint8_t> ratio(n), a(n), b(n);
      random.fill(ratio.span());
      for (Disparity& d : disparity.span()) {
        const int raw = random.between(0, 1) == 0 ? random.between(-32768, 32767)
                                                  : infinity + random.between(-40, 2400);
        d = random.between(0, 9) == 0
                ? Disparity::none()
                : Disparity::from_raw(static_cast<std::int16_t>(std::clamp(raw, -32768, 32767)));
      }
      ref::stereo_spread(disparity.span(), ratio.span(), kSteps,
                         static_cast<std::int16_t>(infinity), a.span());
      neon::stereo_spread(disparity.span(), ratio.span(), kSteps,
                          static_cast<std::int16_t>(infinity), b.span());
      ASSERT_TRUE(std::ranges::equal(a.span(), b.span())) << n << " infinity " << infinity;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
