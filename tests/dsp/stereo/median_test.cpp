#include "dsp/stereo/refine/median.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

Disparity centre(const std::vector<int>& nine) {
  std::vector<Disparity> in;
  for (const int raw : nine) {
    in.push_back(raw < 0 ? Disparity::none() : Disparity::from_raw(static_cast<std::int16_t>(raw)));
  }
  std::vector<Disparity> out(9);
  ref::median_disparity(ImageView<const Disparity>(in.data(), 3, 3), {1, 2}, {out.data(), 3, 3});
  return out[4];
}

TEST(Median, TakesTheMiddleOfTheValidNeighbours) {
  EXPECT_EQ(centre({9, 1, 8, 2, 7, 3, 6, 4, 5}).raw, 5);
  EXPECT_EQ(centre({-1, -1, -1, 2, 70, 30, -1, -1, -1}).raw, 30);
  EXPECT_EQ(centre({-1, 40, -1, -1, 70, 30, -1, 20, -1}).raw, 30);  // of 20 30 40 70
  EXPECT_EQ(centre({-1, -1, -1, -1, 70, -1, -1, -1, -1}).raw, 70);
  EXPECT_FALSE(centre({9, 1, 8, 2, -1, 3, 6, 4, 5}).valid());
}

TEST(Median, NeonEqualsReferenceForEverySizeAndSplit) {
  for (int width = 0; width <= 40; ++width) {
    for (const int height : {1, 2, 5}) {
      for (const int holes : {0, 2, 5, 9}) {  // of ten
        test::GuardedImage<Disparity> in(width, height, width + 2, Disparity::from_raw(77));
        test::GuardedImage<Disparity> reference(width, height, width + 1),
            neon(width, height, width + 3);
        test::Random random(static_cast<std::uint64_t>(width * 31 + height * 7 + holes));
        for (int y = 0; y < height; ++y) {
          for (Disparity& disparity : in.view().row(y)) {
            disparity.raw = random.between(0, 9) < holes
                                ? Disparity::none().raw
                                : static_cast<std::int16_t>(random.between(-32767, 32767));
          }
        }
        ref::median_disparity(in.view(), {0, height}, reference.view());
        neon::median_disparity(in.view(), {0, height / 2}, neon.view());
        neon::median_disparity(in.view(), {height / 2, height}, neon.view());
        for (int y = 0; y < height; ++y) {
          ASSERT_TRUE(std::ranges::equal(reference.view().row(y), neon.view().row(y)))
              << width << " x " << height << ", row " << y;
        }
        EXPECT_TRUE(neon.padding_is(Disparity::none()));
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
