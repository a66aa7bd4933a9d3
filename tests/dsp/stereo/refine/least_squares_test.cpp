#include "dsp/stereo/refine/least_squares.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

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
  for (int s = -7; s <= 7; ++s) {
    Pair pair(5 * 16 + s);
    std::vector<Disparity> row(64, Disparity::from_pixels(5));
    best::refine_least_squares(pair.left.view(), pair.right.view(), 10, 16, 16, row);
    for (std::size_t x = 20; x < 44; ++x) {
      ASSERT_TRUE(row[x].valid()) << s;
      // A triangle's corners are blunt: a sixteenth of tolerance.
      EXPECT_NEAR(row[x].raw, 5 * 16 + s, 1) << "shift " << s << " at " << x;
    }
  }
}

TEST(LeastSquares, DropsWhatWouldMoveByMoreThanHalfAPixel) {
  Pair pair(6 * 16);
  std::vector<Disparity> row(64, Disparity::from_pixels(5));
  best::refine_least_squares(pair.left.view(), pair.right.view(), 10, 16, 16, row);
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

TEST(LeastSquares, EqualsReferenceForEverySizeBlockAndDisparity) {
  for (const int block : {1, 3, 8, 9, 16, 64}) {
    test::check_kernel(std::array<std::size_t, 6>{1, 2, 8, 17, 40, 67}, [&](test::KernelCase& c) {
      const int width = static_cast<int>(c.length());
      const int height = 6;
      const auto left = c.image<std::uint8_t>(width, height);
      const auto right = c.image<std::uint8_t>(width, height);
      for (int y = 0; y < height; ++y) {
        c.fill(left.row(y), 0, 255);
        for (int x = 0; x < width; ++x) {  // alike enough that some shifts are small
          right.at(x, y) = static_cast<std::uint8_t>(std::clamp(
              left.at(std::min(x + 2, width - 1), y) + c.random().between(-9, 9), 0, 255));
        }
      }
      for (const int y : {0, 3, height - 1}) {
        const auto row = c.array<Disparity>(c.length());
        for (Disparity& disparity : row) {
          disparity.raw = static_cast<std::int16_t>(c.draw(-60, 90));
          disparity = c.random().between(0, 5) == 0 ? Disparity::none() : disparity;
        }
        c.run([&] { best::refine_least_squares(left, right, y, block, block, row); });
      }
    });
  }
}

}  // namespace
}  // namespace stof::dsp
