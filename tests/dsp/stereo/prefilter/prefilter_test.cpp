#include "dsp/stereo/prefilter/prefilter.h"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

TEST(ClippedSobel, GivesTheDerivativeOfARamp) {
  // 5 grey levels a column: the derivative over two columns and 1 + 2 + 1 rows is 40, half of it at
  // the borders, where the nearest column is repeated.
  const std::array<std::uint8_t, 6> ramp{10, 15, 20, 25, 30, 35};
  std::array<std::uint8_t, 6> out{};
  best::clipped_sobel(ramp, ramp, ramp, 127, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 6>{147, 167, 167, 167, 167, 147}));
}

TEST(ClippedSobel, ClipsBothSidesAtTheCap) {
  const std::array<std::uint8_t, 4> step{0, 0, 255, 255};
  const std::array<std::uint8_t, 4> fall{255, 255, 0, 0};
  std::array<std::uint8_t, 4> out{};
  best::clipped_sobel(step, step, step, 15, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 4>{15, 30, 30, 15}));
  best::clipped_sobel(fall, fall, fall, 15, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 4>{15, 0, 0, 15}));
}

TEST(ClippedSobel, WeighsTheMiddleRowTwice) {
  const std::array<std::uint8_t, 3> flat{0, 0, 0};
  const std::array<std::uint8_t, 3> step{0, 0, 7};
  std::array<std::uint8_t, 3> out{};
  best::clipped_sobel(step, flat, flat, 100, out);
  EXPECT_EQ(out[1], 107);
  best::clipped_sobel(flat, step, flat, 100, out);
  EXPECT_EQ(out[1], 114);
}

TEST(ClippedSobel, EqualsReferenceForEveryLengthAndCap) {
  for (const int cap : {1, 15, 31, 127}) {
    test::check_kernel([&](test::KernelCase& c) {
      const auto above = c.array<std::uint8_t>(c.length(), 0, 255);
      const auto here = c.array<std::uint8_t>(c.length(), 0, 255);
      const auto below = c.array<std::uint8_t>(c.length(), 0, 255);
      const auto out = c.array<std::uint8_t>(c.length());
      c.run([&] { best::clipped_sobel(above, here, below, cap, out); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
