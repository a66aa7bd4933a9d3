#include "dsp/stereo/cost/prefilter.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

TEST(ClippedSobel, GivesTheDerivativeOfARamp) {
  // 5 grey levels a column: the derivative over two columns and 1 + 2 + 1 rows is 40, half of it at
  // the borders, where the nearest column is repeated.
  const std::array<std::uint8_t, 6> ramp{10, 15, 20, 25, 30, 35};
  std::array<std::uint8_t, 6> out{};
  ref::clipped_sobel(ramp, ramp, ramp, 127, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 6>{147, 167, 167, 167, 167, 147}));
}

TEST(ClippedSobel, ClipsBothSidesAtTheCap) {
  const std::array<std::uint8_t, 4> step{0, 0, 255, 255};
  const std::array<std::uint8_t, 4> fall{255, 255, 0, 0};
  std::array<std::uint8_t, 4> out{};
  ref::clipped_sobel(step, step, step, 15, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 4>{15, 30, 30, 15}));
  ref::clipped_sobel(fall, fall, fall, 15, out);
  EXPECT_EQ(out, (std::array<std::uint8_t, 4>{15, 0, 0, 15}));
}

TEST(ClippedSobel, WeighsTheMiddleRowTwice) {
  const std::array<std::uint8_t, 3> flat{0, 0, 0};
  const std::array<std::uint8_t, 3> step{0, 0, 7};
  std::array<std::uint8_t, 3> out{};
  ref::clipped_sobel(step, flat, flat, 100, out);
  EXPECT_EQ(out[1], 107);
  ref::clipped_sobel(flat, step, flat, 100, out);
  EXPECT_EQ(out[1], 114);
}

TEST(ClippedSobel, VectorsEqualReferenceForEveryLength) {
  for (std::size_t n = 0; n <= 100; ++n) {
    test::GuardedBuffer<std::uint8_t> above(n), here(n), below(n), reference(n), vectors(n);
    test::Random random(n);
    random.fill(above.span());
    random.fill(here.span());
    random.fill(below.span());
    for (const int cap : {1, 15, 31, 127}) {
      ref::clipped_sobel(above.span(), here.span(), below.span(), cap, reference.span());
      for (const Vectors v : test::all_vectors()) {
        const test::UseVectors use(v);
        std::ranges::fill(vectors.span(), std::uint8_t{255});
        best::clipped_sobel(above.span(), here.span(), below.span(), cap, vectors.span());
        for (std::size_t x = 0; x < n; ++x) {
          ASSERT_EQ(reference[x], vectors[x])
              << "length " << n << " cap " << cap << " column " << x;
        }
      }
    }
  }
}

TEST(ClippedSobel, VectorsEqualReferenceAtExtremes) {
  for (const int black : {0, 255}) {
    test::GuardedBuffer<std::uint8_t> row(67), reference(67), vectors(67);
    for (std::size_t x = 0; x < row.size(); ++x) {
      row[x] = static_cast<std::uint8_t>(x % 3 == 0 ? black : 255 - black);
    }
    ref::clipped_sobel(row.span(), row.span(), row.span(), 127, reference.span());
    for (const Vectors v : test::all_vectors()) {
      const test::UseVectors use(v);
      best::clipped_sobel(row.span(), row.span(), row.span(), 127, vectors.span());
      EXPECT_TRUE(std::ranges::equal(reference.span(), vectors.span()));
    }
  }
}

}  // namespace
}  // namespace stof::dsp
