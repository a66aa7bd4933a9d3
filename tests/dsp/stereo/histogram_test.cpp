#include "dsp/stereo/check/histogram.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"

namespace stof::dsp {
namespace {

TEST(Histogram, DropsWhatFewerThanTheShareOfThePixelsHave) {
  // 1000 pixels: 996 of 4 px, 3 of 9 px, 1 of -2 px.
  test::GuardedImage<Disparity> image(50, 20, 53, Disparity::from_pixels(4));
  for (const int x : {3, 30, 49}) {
    image.view().at(x, 19) = Disparity::from_pixels(9);
  }
  image.view().at(0, 0) = Disparity::from_pixels(-2);
  test::GuardedBuffer<std::uint32_t> counts(17);
  drop_rare(image.view(), -2, 3, counts.span());
  EXPECT_EQ(image.view().at(30, 19), Disparity::from_pixels(9));  // just enough
  EXPECT_FALSE(image.view().at(0, 0).valid());
  drop_rare(image.view(), -2, 4, counts.span());
  EXPECT_FALSE(image.view().at(30, 19).valid());
  EXPECT_EQ(image.view().at(1, 0), Disparity::from_pixels(4));
  EXPECT_TRUE(image.padding_is(Disparity::from_pixels(4)));
}

TEST(Histogram, FractionsBelongToTheNearestWholeDisparity) {
  std::vector<Disparity> row(10, Disparity::from_raw(7 * 16 - 8));  // 6.5: seven
  row[0] = Disparity::from_raw(7 * 16 + 7);
  row[1] = Disparity::from_raw(7 * 16 + 8);  // 7.5: eight, alone
  std::vector<std::uint32_t> counts(9);
  drop_rare({row.data(), 10, 1}, 0, 200, counts);
  EXPECT_TRUE(row[0].valid());
  EXPECT_FALSE(row[1].valid());
  EXPECT_TRUE(row[9].valid());
}

TEST(Histogram, EndsOfTheRangeAndEmptyImagesAreHarmless) {
  test::GuardedBuffer<std::uint32_t> counts(2);  // one candidate
  std::vector<Disparity> row{Disparity::from_raw(-32767), Disparity::from_raw(32767), {}};
  drop_rare({row.data(), 3, 1}, 0, 1000, counts.span());
  EXPECT_TRUE(std::ranges::none_of(row, &Disparity::valid));
  drop_rare({}, 0, 1000, counts.span());
}

}  // namespace
}  // namespace stof::dsp
