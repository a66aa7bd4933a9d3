#include "dsp/fusion/interval/disparity_sigma.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr SigmaTable kSteps{4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 56, 64, 100, 150, 200, 255};

int sigma_of(Disparity disparity, std::uint8_t ratio, std::int16_t infinity = -16384) {
  std::uint8_t half = 9;
  best::disparity_sigma({&disparity, 1}, {&ratio, 1}, kSteps, infinity, {&half, 1});
  return half;
}

TEST(DisparitySigma, IsTheTablesStepOfTheRatio) {
  for (int ratio = 0; ratio < 256; ++ratio) {
    EXPECT_EQ(sigma_of(Disparity::from_pixels(60), static_cast<std::uint8_t>(ratio)),
              kSteps[static_cast<std::size_t>(ratio / 16)]);
  }
}

TEST(DisparitySigma, IsAtMostAnEighthOfTheParallax) {
  EXPECT_EQ(sigma_of(Disparity::from_pixels(10), 255, 0), 20);
  EXPECT_EQ(sigma_of(Disparity::from_pixels(10), 255, -160), 40);
  EXPECT_EQ(sigma_of(Disparity::from_pixels(10), 255, 16), 18);
  EXPECT_EQ(sigma_of(Disparity::from_pixels(1), 255, 0), kLeastHalfWidth);
  EXPECT_EQ(sigma_of(Disparity::from_pixels(-3), 255, 0), kLeastHalfWidth);  // behind infinity
}

TEST(DisparitySigma, OfNoDisparityIsNone) { EXPECT_EQ(sigma_of(Disparity::none(), 255), 0); }

TEST(DisparitySigma, TablesNeverFallWithTheRatio) {
  for (const SigmaTable& table : {kBlockSigma, kPathSigma}) {
    EXPECT_TRUE(std::ranges::is_sorted(table));
    EXPECT_GE(table.front(), kLeastHalfWidth);
  }
}

TEST(DisparitySigma, EqualsReferenceForEveryLengthAndAnyDisparity) {
  for (const int infinity : {-16384, -640, 0, 333, 16384}) {
    test::check_kernel([&](test::KernelCase& c) {
      const auto ratio = c.array<std::uint8_t>(c.length(), 0, 255);
      const auto disparity = c.array<Disparity>(c.length());
      for (Disparity& d : disparity) {
        const int near = std::clamp(infinity + c.random().between(-40, 2400), -32768, 32767);
        d = c.random().between(0, 1) == 0 ? d
                                          : Disparity::from_raw(static_cast<std::int16_t>(near));
        d = c.random().between(0, 9) == 0 ? Disparity::none() : d;
      }
      const auto half = c.array<std::uint8_t>(c.length());
      c.run([&] {
        best::disparity_sigma(disparity, ratio, kSteps, static_cast<std::int16_t>(infinity), half);
      });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
