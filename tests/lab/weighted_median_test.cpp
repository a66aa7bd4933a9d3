#include "lab/weighted_median.h"

#include <vector>

#include <gtest/gtest.h>

namespace stof::lab {
namespace {

constexpr int kSide = 9;

struct Scene {
  std::vector<std::uint8_t> grey = std::vector<std::uint8_t>(kSide * kSide, 100);
  std::vector<Disparity> map = std::vector<Disparity>(kSide * kSide, Disparity::from_pixels(10));

  Disparity& at(int x, int y) { return map[static_cast<std::size_t>(y * kSide + x)]; }
  std::vector<Disparity> smoothed() const {
    std::vector<Disparity> out(map.size());
    weighted_median({grey.data(), kSide, kSide}, {map.data(), kSide, kSide},
                    {out.data(), kSide, kSide});
    return out;
  }
};

TEST(WeightedMedian, DropsWhatStandsAlone) {
  Scene scene;
  scene.at(4, 4) = Disparity::from_pixels(40);
  EXPECT_EQ(scene.smoothed(), Scene().map);
}

TEST(WeightedMedian, MovesAnEdgeOfTheMapToThatOfThePicture) {
  Scene scene;
  Scene expected;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      scene.grey[static_cast<std::size_t>(y * kSide + x)] = x < 4 ? 100 : 200;
      scene.at(x, y) = Disparity::from_pixels(x < 5 ? 10 : 20);  // a column too far
      expected.at(x, y) = Disparity::from_pixels(x < 4 ? 10 : 20);
    }
  }
  EXPECT_EQ(scene.smoothed(), expected.map);
}

TEST(WeightedMedian, KeepsSlopesAndHoles) {
  Scene scene;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      scene.at(x, y) = Disparity::from_raw(static_cast<std::int16_t>(100 + 3 * x));
    }
  }
  scene.at(4, 4) = Disparity::none();
  EXPECT_EQ(scene.smoothed(), scene.map);
}

TEST(WeightedMedian, TakesAnySize) {
  for (const int width : {1, 2, 3, 7}) {
    const std::vector<std::uint8_t> grey(static_cast<std::size_t>(2 * width), 5);
    const std::vector<Disparity> map(static_cast<std::size_t>(2 * width),
                                     Disparity::from_pixels(3));
    std::vector<Disparity> out(map.size());
    weighted_median({grey.data(), width, 2}, {map.data(), width, 2}, {out.data(), width, 2});
    EXPECT_EQ(out, map);
  }
}

}  // namespace
}  // namespace stof::lab
