#include "host/picture/depth_picture.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

constexpr Rgb kWhite{255, 255, 255};

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

TEST(DrawText, DrawsDigitsAsTheyAreReadAndCutsWhatLiesOutside) {
  dataset::Image<Rgb> picture(5, 7);
  draw_text(picture, 0, 3, "1", kWhite);
  std::string seen;
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 5; ++x) {
      seen += picture.view().at(x, y) == kWhite ? '#' : '.';
    }
    seen += '\n';
  }
  EXPECT_EQ(seen, "..#..\n.##..\n..#..\n..#..\n..#..\n..#..\n.###.\n");
  for (const auto& [x, y] : {std::pair{-3, 3}, {4, 3}, {0, -2}, {0, 8}, {-100, 100}}) {
    draw_text(picture, x, y, "0123456789.m none?", kWhite);  // the sanitizers watch
  }
}

TEST(DrawText, IsAsWideAsItSays) {
  EXPECT_EQ(text_width(""), 0);
  EXPECT_EQ(text_width("8"), 5);
  EXPECT_EQ(text_width("1.5 m"), 29);
}

}  // namespace
}  // namespace stof::host
