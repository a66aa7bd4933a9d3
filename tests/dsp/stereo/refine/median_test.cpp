#include "dsp/stereo/refine/median.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

Disparity centre(const std::vector<int>& nine) {
  std::vector<Disparity> in;
  for (const int raw : nine) {
    in.push_back(raw < 0 ? Disparity::none() : Disparity::from_raw(static_cast<std::int16_t>(raw)));
  }
  std::vector<Disparity> out(9);
  best::median_disparity(ImageView<const Disparity>(in.data(), 3, 3), {1, 2}, {out.data(), 3, 3});
  return out[4];
}

TEST(Median, TakesTheMiddleOfTheValidNeighbours) {
  EXPECT_EQ(centre({9, 1, 8, 2, 7, 3, 6, 4, 5}).raw, 5);
  EXPECT_EQ(centre({-1, -1, -1, 2, 70, 30, -1, -1, -1}).raw, 30);
  EXPECT_EQ(centre({-1, 40, -1, -1, 70, 30, -1, 20, -1}).raw, 30);  // of 20 30 40 70
  EXPECT_EQ(centre({-1, -1, -1, -1, 70, -1, -1, -1, -1}).raw, 70);
  EXPECT_FALSE(centre({9, 1, 8, 2, -1, 3, 6, 4, 5}).valid());
}

TEST(Median, EqualsReferenceForEverySizeAndSplit) {
  for (const int height : {1, 2, 5}) {
    for (const int holes : {0, 2, 5, 9}) {  // of ten
      test::check_kernel([&](test::KernelCase& c) {
        const int width = static_cast<int>(c.length());
        const auto in = c.image<Disparity>(width, height);
        for (int y = 0; y < height; ++y) {
          for (Disparity& disparity : in.row(y)) {
            disparity.raw = c.random().between(0, 9) < holes
                                ? Disparity::none().raw
                                : static_cast<std::int16_t>(c.draw(-32767, 32767));
          }
        }
        const auto whole = c.image<Disparity>(width, height);
        const auto halves = c.image<Disparity>(width, height);
        c.run([&] { best::median_disparity(in, {0, height}, whole); });
        c.run([&] {
          best::median_disparity(in, {0, height / 2}, halves);
          best::median_disparity(in, {height / 2, height}, halves);
        });
        for (int y = 0; y < height; ++y) {
          ASSERT_TRUE(std::ranges::equal(whole.row(y), halves.row(y))) << "row " << y;
        }
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
