#include "host/picture/disparity_picture.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/no_value.h"

namespace stof::host {
namespace {

using test::kNone;

TEST(DisparityScale, IsWarmWhereNearAndClampsOutside) {
  const DisparityScale scale{.far_px = 5, .near_px = 55};
  EXPECT_GT(scale.colour(55).red, scale.colour(55).blue);
  EXPECT_LT(scale.colour(5).red, scale.colour(5).blue);
  EXPECT_EQ(scale.colour(80), scale.colour(55));
  EXPECT_EQ(scale.colour(-3), scale.colour(5));
}

TEST(DisparityScale, HasRoundTicksInside) {
  EXPECT_EQ((DisparityScale{.far_px = 5, .near_px = 55}.ticks()),
            (std::vector<double>{10, 20, 30, 40, 50}));
  EXPECT_EQ((DisparityScale{.far_px = 3, .near_px = 4}.ticks().front()), 3);
  EXPECT_EQ((DisparityScale{.far_px = -8, .near_px = 8}.ticks()), (std::vector<double>{-5, 0, 5}));
}

TEST(DisparityPicture, NeverGivesADisparityTheColourOfNone) {
  dataset::Image<float> ramp(1000, 1);
  for (int x = 0; x < ramp.width; ++x) {
    ramp.view().at(x, 0) = static_cast<float>(x) / 10 - 10;
  }
  for (const Rgb& pixel : disparity_picture(ramp, {.far_px = 0, .near_px = 60}).pixels) {
    EXPECT_GT(pixel.red + pixel.green + pixel.blue, 180);
  }
  const dataset::Image<float> none(12, 12, kNone);
  for (const Rgb& pixel : disparity_picture(none, {}).pixels) {
    EXPECT_LT(pixel.red + pixel.green + pixel.blue, 150);
  }
}

TEST(Differences, TellNearFromFarAndMissingFromUnknown) {
  dataset::Image<float> disparity(6, 1);
  disparity.pixels = {10, 11, 11.5F, 8.5F, kNone, kNone};
  dataset::Image<float> truth(6, 1, 10.0F);
  truth.pixels[5] = kNone;
  EXPECT_EQ(differences(disparity, truth).pixels,
            (std::vector<Finding>{Finding::kRight, Finding::kRight, Finding::kTooNear,
                                  Finding::kTooFar, Finding::kMissing, Finding::kUnknown}));
}

TEST(FindingPicture, ShowsTheLeftPictureWhereItIsRightAndPalerWhereOccluded) {
  dataset::Image<Finding> findings(3, 1);
  findings.pixels = {Finding::kRight, Finding::kTooNear, Finding::kTooNear};
  const dataset::Image<std::uint8_t> left(3, 1, 100);
  dataset::Image<std::uint8_t> pale(3, 1);
  pale.pixels[2] = 1;
  const dataset::Image<Rgb> picture = finding_picture(findings, left, pale);
  EXPECT_EQ(picture.pixels[0], as_colour(left, true).pixels[0]);
  EXPECT_EQ(picture.pixels[1], finding_colour(Finding::kTooNear));
  EXPECT_GT(picture.pixels[2].green, picture.pixels[1].green);
}

TEST(FindingColour, DiffersForEveryFinding) {
  std::set<int> colours;
  for (int i = 0; i <= static_cast<int>(Finding::kFilled); ++i) {
    const Rgb colour = finding_colour(static_cast<Finding>(i));
    colours.insert(colour.red << 16 | colour.green << 8 | colour.blue);
  }
  EXPECT_EQ(colours.size(), static_cast<std::size_t>(Finding::kFilled) + 1);
}

TEST(MetricPicture, ShowsWhatIsNotInFrontAsNone) {
  dataset::Image<float> depth(3, 1);
  depth.pixels = {2, 0, kNone};
  const dataset::Image<Rgb> picture = metric_picture(depth, {.near_m = 1, .far_m = 8});
  EXPECT_EQ(picture.pixels[1], none_colour(1, 0));
  EXPECT_EQ(picture.pixels[2], none_colour(2, 0));
  EXPECT_NE(picture.pixels[0], none_colour(0, 0));
}

TEST(DrawFrame, SurroundsTheRectangleAndIsCutAtTheBorder) {
  constexpr Rgb kInk{1, 2, 3};
  dataset::Image<Rgb> picture(8, 6);
  draw_frame(picture, 0, 1, 3, 3, 1, kInk);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      const bool frame = x <= 4 && y <= 4 && (x == 4 || y == 0 || y == 4);
      EXPECT_EQ(picture.view().at(x, y) == kInk, frame) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace stof::host
