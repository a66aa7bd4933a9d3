#include "host/picture/error_picture.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "host/picture/legend.h"

namespace stof::host {
namespace {

TEST(ErrorPicture, ShowsSignsAsColours) {
  dataset::Image<float> values(2, 1);
  values.pixels = {-3.0F, 3.0F};
  const dataset::Image<Rgb> picture = error_picture(values, largest_error(values));
  EXPECT_GT(picture.pixels[0].blue, picture.pixels[0].red);
  EXPECT_GT(picture.pixels[1].red, picture.pixels[1].blue);
  values.pixels = {0.0F, std::numeric_limits<float>::quiet_NaN()};
  const dataset::Image<Rgb> nothing = error_picture(values, largest_error(values));
  constexpr Rgb kWhite{255, 255, 255};
  EXPECT_EQ(nothing.pixels[0], kWhite);
  const Rgb unknown = nothing.pixels[1];
  EXPECT_EQ(unknown.red, unknown.blue);
  EXPECT_NE(unknown, kWhite);
}

TEST(DepthErrorPicture, SaysBesideTheMapWhatItsColoursMean) {
  const dataset::Image<Rgb> picture = depth_error_picture(dataset::Image<float>(120, 130), 0.05);
  ASSERT_EQ(picture.width, 120 + kLegendWidth);
  EXPECT_EQ(picture.height, 130);
  for (const double error : {-1.0, 1.0, std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(std::ranges::find(picture.pixels, error_colour(error)), picture.pixels.end());
  }
}

TEST(LargestError, LeavesOutWhatIsNotFinite) {
  dataset::Image<float> values(3, 1);
  values.pixels = {-3.0F, 2.0F, std::numeric_limits<float>::infinity()};
  EXPECT_EQ(largest_error(values), 3);
  values.pixels = {0.0F, 0.0F, 0.0F};
  EXPECT_EQ(largest_error(values), 1);
}

}  // namespace
}  // namespace stof::host
