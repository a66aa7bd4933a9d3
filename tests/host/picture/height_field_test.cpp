#include "host/picture/height_field.h"

#include <cmath>

#include <gtest/gtest.h>

#include "host/picture/rasteriser.h"
#include "tests/support/no_value.h"

namespace stof::host {
namespace {

using test::kNone;

// Pixels clearly brighter than plate and background, which are what a white texture becomes.
int bright(const dataset::Image<Rgb>& picture) {
  return static_cast<int>(
      std::ranges::count_if(picture.pixels, [](const Rgb& pixel) { return pixel.green > 110; }));
}

dataset::Image<Rgb> view_of(const dataset::Image<float>& disparity) {
  const dataset::Image<std::uint8_t> white(disparity.width, disparity.height, 255);
  HeightFieldView view;
  view.width = 160;
  return height_field_picture(disparity, disparity, 0, 20, white, view);
}

TEST(Rasteriser, ShowsTheNearerOfTwoTrianglesInAnyOrder) {
  const auto triangle = [](double closeness, const Light& light) {
    return std::array<Corner, 3>{Corner{.u = -40, .v = -40, .closeness = closeness, .light = light},
                                 Corner{.u = 80, .v = -40, .closeness = closeness, .light = light},
                                 Corner{.u = -40, .v = 80, .closeness = closeness, .light = light}};
  };
  for (const bool near_first : {true, false}) {
    Rasteriser screen(8, 8);
    screen.draw(near_first ? triangle(2, {1, 0, 0}) : triangle(1, {0, 0, 1}));
    screen.draw(near_first ? triangle(1, {0, 0, 1}) : triangle(2, {1, 0, 0}));
    EXPECT_EQ(screen.picture().view().at(1, 1), (Rgb{255, 0, 0}));
  }
}

TEST(Rasteriser, CutsWhatLiesOutsideAndIgnoresWhatHasNoArea) {
  Rasteriser screen(8, 8);
  const dataset::Image<Rgb> empty = screen.picture();
  screen.draw({Corner{.u = 20, .v = 20, .closeness = 1, .light = {1, 1, 1}},
               Corner{.u = 30, .v = 20, .closeness = 1, .light = {1, 1, 1}},
               Corner{.u = 20, .v = 30, .closeness = 1, .light = {1, 1, 1}}});
  screen.draw({Corner{.u = 1, .v = 1, .closeness = 1, .light = {1, 1, 1}},
               Corner{.u = 5, .v = 5, .closeness = 1, .light = {1, 1, 1}},
               Corner{.u = 3, .v = 3, .closeness = 1, .light = {1, 1, 1}}});
  EXPECT_EQ(screen.picture().pixels, empty.pixels);
}

TEST(HeightFieldPicture, ShowsThePlateWhereThereIsNoDisparity) {
  dataset::Image<float> disparity(40, 30, 10.0F);
  const int whole = bright(view_of(disparity));
  EXPECT_GT(whole, 4000);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 20; ++x) {
      disparity.view().at(x, y) = kNone;
    }
  }
  const int half = bright(view_of(disparity));
  EXPECT_LT(half, whole * 6 / 10);
  EXPECT_GT(half, whole * 4 / 10);
  EXPECT_EQ(bright(view_of(dataset::Image<float>(40, 30, kNone))), 0);
}

TEST(HeightFieldPicture, IsOfTheAskedWidthForEverySize) {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(1, 9), std::pair(9, 1), std::pair(2, 2), std::pair(33, 17)}) {
    const dataset::Image<Rgb> picture = view_of(dataset::Image<float>(width, height, 7.0F));
    EXPECT_EQ(picture.width, 160);
    EXPECT_GT(picture.height, 0);
  }
}

TEST(HeightFieldPicture, IsCutToItsFrame) {
  const dataset::Image<std::uint8_t> white(40, 30, 255);
  const dataset::Image<float> low(40, 30, 1.0F);
  const dataset::Image<float> high(40, 30, 19.0F);
  HeightFieldView view;
  view.width = 160;
  const dataset::Image<Rgb> of_low = height_field_picture(low, high, 0, 20, white, view);
  const dataset::Image<Rgb> of_high = height_field_picture(high, high, 0, 20, white, view);
  EXPECT_EQ(of_low.height, of_high.height);
  EXPECT_LT(bright(of_low), bright(of_high));  // nearer is larger
}

TEST(SmoothedWithin, MixesSmallStepsAndKeepsLargeOnesAndHoles) {
  dataset::Image<float> steps(6, 1);
  steps.pixels = {1, 2, 2, 8, 8, kNone};
  const dataset::Image<float> smooth = smoothed_within(steps, 1, 1.25F);
  EXPECT_FLOAT_EQ(smooth.pixels[0], 1.5F);
  EXPECT_FLOAT_EQ(smooth.pixels[1], 5.0F / 3);
  EXPECT_FLOAT_EQ(smooth.pixels[2], 2);
  EXPECT_FLOAT_EQ(smooth.pixels[3], 8);
  EXPECT_TRUE(std::isinf(smooth.pixels[5]));
}

}  // namespace
}  // namespace stof::host
