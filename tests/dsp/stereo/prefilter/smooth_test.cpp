#include "dsp/stereo/prefilter/smooth.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

TEST(Binomial, SpreadsAPointByItsWeights) {
  const std::array<std::uint8_t, 5> dark{}, point{0, 0, 160, 0, 0};
  std::array<std::uint8_t, 5> out{};
  best::binomial(dark, point, dark, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 5>{0, 20, 40, 20, 0}));
  best::binomial(point, dark, dark, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 5>{0, 10, 20, 10, 0}));
}

TEST(Binomial, RoundsHalfUpAndRepeatsTheBorder) {
  const std::array<std::uint8_t, 3> dark{}, step{0, 0, 1}, half{2, 0, 0};
  std::array<std::uint8_t, 3> out{};
  best::binomial(dark, step, dark, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 3>{0, 0, 0}));  // 6 / 16 at the border
  best::binomial(step, step, step, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 3>{0, 0, 1}));  // 12 / 16
  best::binomial(half, dark, half, out);
  EXPECT_EQ(out[0], 1);  // (2 + 2) * 3 / 16 = 12 / 16
  EXPECT_EQ(out[1], 0);  // 4 / 16
  best::binomial(half, half, dark, out);
  EXPECT_EQ(out[1], 0);  // 6 / 16
  best::binomial(half, half, half, out);
  EXPECT_EQ(out[1], 1);  // 8 / 16
}

TEST(Binomial, LeavesAFlatPictureAlone) {
  for (const int grey : {0, 1, 127, 254, 255}) {
    test::GuardedBuffer<std::uint8_t> row(37, static_cast<std::uint8_t>(grey)), out(37);
    best::binomial(row.span(), row.span(), row.span(), out.span());
    EXPECT_TRUE(std::ranges::equal(row.span(), out.span())) << grey;
  }
}

TEST(Binomial, EqualsReferenceForEveryLength) {
  test::check_kernel([](test::KernelCase& c) {
    const auto above = c.array<std::uint8_t>(c.length(), 0, 255);
    const auto here = c.array<std::uint8_t>(c.length(), 0, 255);
    const auto below = c.array<std::uint8_t>(c.length(), 0, 255);
    const auto out = c.array<std::uint8_t>(c.length());
    c.run([&] { best::binomial(above, here, below, out); });
  });
}

}  // namespace
}  // namespace stof::dsp
