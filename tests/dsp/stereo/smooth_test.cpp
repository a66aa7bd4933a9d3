#include "dsp/stereo/cost/smooth.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

TEST(Binomial, SpreadsAPointByItsWeights) {
  const std::array<std::uint8_t, 5> dark{}, point{0, 0, 160, 0, 0};
  std::array<std::uint8_t, 5> out{};
  ref::binomial(dark, point, dark, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 5>{0, 20, 40, 20, 0}));
  ref::binomial(point, dark, dark, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 5>{0, 10, 20, 10, 0}));
}

TEST(Binomial, RoundsHalfUpAndRepeatsTheBorder) {
  const std::array<std::uint8_t, 3> dark{}, step{0, 0, 1}, half{2, 0, 0};
  std::array<std::uint8_t, 3> out{};
  ref::binomial(dark, step, dark, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 3>{0, 0, 0}));  // 6 / 16 at the border
  ref::binomial(step, step, step, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 3>{0, 0, 1}));  // 12 / 16
  ref::binomial(half, dark, half, out);
  EXPECT_EQ(out[0], 1);  // (2 + 2) * 3 / 16 = 12 / 16
  EXPECT_EQ(out[1], 0);  // 4 / 16
  ref::binomial(half, half, dark, out);
  EXPECT_EQ(out[1], 0);  // 6 / 16
  ref::binomial(half, half, half, out);
  EXPECT_EQ(out[1], 1);  // 8 / 16
}

TEST(Binomial, LeavesAFlatPictureAlone) {
  for (const int grey : {0, 1, 127, 254, 255}) {
    test::GuardedBuffer<std::uint8_t> row(37, static_cast<std::uint8_t>(grey)), out(37);
    best::binomial(row.span(), row.span(), row.span(), out.span());
    EXPECT_TRUE(std::ranges::equal(row.span(), out.span())) << grey;
  }
}

TEST(Binomial, VectorsEqualReferenceForEveryLength) {
  for (std::size_t n = 0; n <= 100; ++n) {
    test::GuardedBuffer<std::uint8_t> above(n), here(n), below(n), reference(n, 1), vectors(n, 2);
    test::Random random(n);
    random.fill(above.span());
    random.fill(here.span());
    random.fill(below.span());
    ref::binomial(above.span(), here.span(), below.span(), reference.span());
    for (const Vectors v : test::all_vectors()) {
      const test::UseVectors use(v);
      std::ranges::fill(vectors.span(), std::uint8_t{2});
      best::binomial(above.span(), here.span(), below.span(), vectors.span());
      ASSERT_TRUE(std::ranges::equal(reference.span(), vectors.span())) << "length " << n;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
