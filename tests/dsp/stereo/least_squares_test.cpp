#include "dsp/stereo/refine/least_squares.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using Refine = RefineLeastSquares*;

// A smooth pattern of period 16 px with `shift` sixteenths: a triangle between 40 and 168.
std::uint8_t pattern(int sixteenths) {
  const int phase = ((sixteenths % 256) + 256) % 256;
  return static_cast<std::uint8_t>(40 + (phase < 128 ? phase : 256 - phase));
}

struct Pair {
  test::GuardedImage<std::uint8_t> left{64, 20, 64};
  test::GuardedImage<std::uint8_t> right{64, 20, 64};
  // left(x) = right(x - disparity): the right picture is the pattern moved to the left.
  explicit Pair(int disparity_sixteenths) {
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 64; ++x) {
        left.view().at(x, y) = pattern(16 * x + 40 * y);
        right.view().at(x, y) = pattern(16 * x + 40 * y + disparity_sixteenths);
      }
    }
  }
};

TEST(LeastSquares, FindsAKnownShiftWithItsSign) {
  for (const Refine refine : {static_cast<Refine>(ref::refine_least_squares),
                              static_cast<Refine>(neon::refine_least_squares)}) {
    for (int s = -7; s <= 7; ++s) {
      Pair pair(5 * 16 + s);
      std::vector<Disparity> row(64, Disparity::from_pixels(5));
      refine(pair.left.view(), pair.right.view(), 10, 16, 16, row);
      for (std::size_t x = 20; x < 44; ++x) {
        ASSERT_TRUE(row[x].valid()) << s;
        // A triangle's corners are blunt: a sixteenth of tolerance.
        EXPECT_NEAR(row[x].raw, 5 * 16 + s, 1) << "shift " << s << " at " << x;
      }
    }
  }
}

TEST(LeastSquares, DropsWhatWouldMoveByMoreThanHalfAPixel) {
  Pair pair(6 * 16);
  std::vector<Disparity> row(64, Disparity::from_pixels(5));
  ref::refine_least_squares(pair.left.view(), pair.right.view(), 10, 16, 16, row);
  EXPECT_TRUE(
      std::none_of(row.begin() + 20, row.begin() + 44, [](Disparity d) { return d.valid(); }));
}

TEST(LeastSquares, RoundsHalvesAwayFromZeroAndKeepsTheLimit) {
  EXPECT_EQ(shifted_disparity(3, 1, 4).raw, 3 * 16 + 8);  // s = 1/2 stays
  EXPECT_EQ(shifted_disparity(3, -1, 4).raw, 3 * 16 - 8);
  EXPECT_FALSE(shifted_disparity(3, 1, 3).valid());
  EXPECT_EQ(shifted_disparity(3, 1, 64).raw, 3 * 16 + 1);  // 1/32 px
  EXPECT_EQ(shifted_disparity(3, -1, 64).raw, 3 * 16 - 1);
  EXPECT_EQ(shifted_disparity(3, 1, 65).raw, 3 * 16);
  EXPECT_EQ(shifted_disparity(3, 0, 0).raw, 3 * 16);  // flat: nothing to fit
  EXPECT_FALSE(shifted_disparity(3, 1, 0).valid());
  EXPECT_EQ(shifted_disparity(0, 266338304, 1065353216).raw, 8);  // the largest block's sums
}

TEST(LeastSquares, NeonEqualsReferenceForEverySizeBlockAndDisparity) {
  for (const int width : {1, 2, 8, 17, 40, 67}) {
    for (const int block : {1, 3, 8, 9, 16, 64}) {
      const int height = 6;
      test::GuardedImage<std::uint8_t> left(width, height, width), right(width, height, width);
      test::Random random(static_cast<std::uint64_t>(width * 100 + block));
      for (int y = 0; y < height; ++y) {
        random.fill(left.view().row(y), 0, 255);
        for (int x = 0; x < width; ++x) {  // alike enough that some shifts are small
          right.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(
              left.view().at(std::min(x + 2, width - 1), y) + random.between(-9, 9), 0, 255));
        }
      }
      test::GuardedBuffer<Disparity> reference(static_cast<std::size_t>(width)),
          neon(static_cast<std::size_t>(width));
      for (const int y : {0, 3, height - 1}) {
        for (Disparity& disparity : reference.span()) {
          disparity.raw = static_cast<std::int16_t>(random.between(-60, 90));
          disparity = random.between(0, 5) == 0 ? Disparity::none() : disparity;
        }
        std::ranges::copy(reference.span(), neon.span().begin());
        ref::refine_least_squares(left.view(), right.view(), y, block, block, reference.span());
        neon::refine_least_squares(left.view(), right.view(), y, block, block, neon.span());
        ASSERT_TRUE(std::ranges::equal(reference.span(), neon.span()))
            << width << ", block " << block;
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
