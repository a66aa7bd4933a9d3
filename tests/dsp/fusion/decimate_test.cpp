#include "dsp/fusion/decimate.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

using test::GuardedImage;
using test::Random;

struct Map {
  Map(int w, int h) : depth(w, h, w + 3), width(w, h, w + 1) {}
  DepthMap view() { return {.depth = depth.view(), .width = width.view(), .source = {}}; }

  GuardedImage<QuarterMm> depth;
  GuardedImage<QuarterMm> width;
};

// The sentence of the header, pixel by pixel.
NearestPixel plain(const DepthMap& map, int step, int column, int row) {
  NearestPixel nearest;
  int bound = 0;
  for (int y = row * step; y < std::min((row + 1) * step, map.depth.height()); ++y) {
    for (int x = column * step; x < std::min((column + 1) * step, map.depth.width()); ++x) {
      const int depth = map.depth.at(x, y);
      const int here = 2 * depth - map.width.at(x, y);
      if (depth != 0 && (nearest.depth == 0 || here < bound)) {
        bound = here;
        nearest = {.x = x, .y = y, .depth = map.depth.at(x, y), .width = map.width.at(x, y)};
      }
    }
  }
  return nearest;
}

TEST(DecimateTest, TellsTheNearestBoundOfEachBlock) {
  for (const int step : {1, 2, 3, 4, 7, 8, 16, 63, 64}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE("step " + std::to_string(step) + " seed " + std::to_string(seed));
      Random random(seed);
      Map map(random.between(1, 150), random.between(1, 40));
      const int most = random.between(0, 1) == 0 ? 3 : 65535;  // equal bounds, and any
      const int least = random.between(-2 * most, 0);          // below 0: none
      for (int y = 0; y < map.depth.view().height(); ++y) {
        for (QuarterMm& depth : map.depth.view().row(y)) {
          depth = static_cast<QuarterMm>(std::max(0, random.between(least, most)));
        }
        random.fill(map.width.view().row(y), 0, most);
      }
      const int columns = decimated(map.depth.view().width(), step);
      const int rows = decimated(map.depth.view().height(), step);
      GuardedImage<QuarterMm> depth(columns, rows, columns + 2, 7);
      GuardedImage<QuarterMm> width(columns, rows, columns);
      decimate(map.view(), step, depth.view(), width.view());
      EXPECT_TRUE(depth.padding_is(7));
      for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
          const NearestPixel want = plain(map.view(), step, column, row);
          ASSERT_EQ(depth.view().at(column, row), want.depth);
          ASSERT_EQ(width.view().at(column, row), want.width);
          const NearestPixel got = nearest_pixel(map.view(), step, column, row);
          if (want.depth != kNoDepth) {
            ASSERT_EQ(got.x, want.x);
            ASSERT_EQ(got.y, want.y);
          }
        }
      }
    }
  }
}

TEST(DecimateTest, OneThinPoleIsNotLost) {
  Map map(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      map.depth.view().at(x, y) = x == 21 ? 4000 : 12000;
      map.width.view().at(x, y) = 200;
    }
  }
  GuardedImage<QuarterMm> depth(8, 8, 8);
  GuardedImage<QuarterMm> width(8, 8, 8);
  decimate(map.view(), 8, depth.view(), width.view());
  EXPECT_EQ(depth.view().at(2, 5), 4000);
  EXPECT_EQ(depth.view().at(3, 5), 12000);
}

}  // namespace
}  // namespace stof::dsp
