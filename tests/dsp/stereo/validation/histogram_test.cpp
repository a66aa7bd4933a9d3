#include "dsp/stereo/validation/histogram.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

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

TEST(Histogram, EqualsPlainCountingForEveryWidth) {
  for (int width = 1; width <= 140; ++width) {
    test::Random random(static_cast<std::uint64_t>(width));
    const int least = random.between(-20, 20);
    const int candidates = random.between(1, 40);
    const int permille = random.between(0, 60);
    test::GuardedImage<Disparity> image(width, 3, width + 1, Disparity::from_raw(7));
    const auto bin = [&](Disparity disparity) {
      const int whole = static_cast<int>(std::floor((disparity.raw + 8) / 16.0));
      return std::clamp(whole - least, 0, candidates);
    };
    std::vector<int> plain(static_cast<std::size_t>(candidates) + 1);
    for (int y = 0; y < 3; ++y) {
      for (Disparity& disparity : image.view().row(y)) {
        const int raw = random.between(0, 9) == 0 ? random.between(-32768, 32767)
                                                  : random.between(least * 16, (least + 9) * 16);
        disparity = random.between(0, 4) == 0 ? Disparity::none()
                                              : Disparity::from_raw(static_cast<std::int16_t>(raw));
        plain[static_cast<std::size_t>(bin(disparity))] += disparity.valid() ? 1 : 0;
      }
    }
    std::vector<Disparity> expected;
    for (int y = 0; y < 3; ++y) {
      for (const Disparity disparity : image.view().row(y)) {
        const bool rare =
            plain[static_cast<std::size_t>(bin(disparity))] * 1000 < permille * 3 * width;
        expected.push_back(rare ? Disparity::none() : disparity);
      }
    }
    test::GuardedBuffer<std::uint32_t> counts(plain.size());
    drop_rare(image.view(), least, permille, counts.span());
    for (int i = 0; i < 3 * width; ++i) {
      ASSERT_EQ(image.view().at(i % width, i / width), expected[static_cast<std::size_t>(i)])
          << "width " << width << ", pixel " << i;
    }
    ASSERT_TRUE(image.padding_is(Disparity::from_raw(7)));
  }
}

}  // namespace
}  // namespace stof::dsp
