#include "host/picture/depth_picture.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "host/picture/legend.h"

namespace stof::host {
namespace {

TEST(DepthPicture, ColoursEveryDepthByTheScaleAndNothingElse) {
  const ColourScale scale;
  dataset::Image<dsp::QuarterMm> depth(3, 1);
  depth.pixels = {4000, 0, 20000};
  const dataset::Image<Rgb> picture = depth_picture(depth, scale);
  EXPECT_EQ(picture.view().at(0, 0), scale.colour(1));
  EXPECT_EQ(picture.view().at(2, 0), scale.colour(5));
  const Rgb none = picture.view().at(1, 0);
  EXPECT_LE(
      std::max({none.red, none.green, none.blue}) - std::min({none.red, none.green, none.blue}), 8);
  EXPECT_LE(none.red, 64);
}

TEST(DepthPicture, DrawsTheWholeScaleBesideTheMap) {
  const dataset::Image<Rgb> picture = depth_picture(dataset::Image<dsp::QuarterMm>(200, 150), {});
  ASSERT_EQ(picture.width, 200 + kLegendWidth);
  ASSERT_EQ(picture.height, 150);
  for (const double position : {0.0, 1.0}) {
    EXPECT_NE(std::ranges::find(picture.pixels, scale_colour(position)), picture.pixels.end());
  }
}

TEST(DepthPicture, ExistsForMapsOfEverySize) {
  for (const int side : {0, 1, 2, 95, 96, 97}) {
    const dataset::Image<Rgb> picture =
        depth_picture(dataset::Image<dsp::QuarterMm>(side, side), {});
    EXPECT_EQ(picture.width, side + kLegendWidth);
    EXPECT_EQ(picture.height, std::max(side, 96));
  }
}

}  // namespace
}  // namespace stof::host
