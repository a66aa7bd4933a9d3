#include "host/evaluate/stereo/disparity_score.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/support/no_value.h"

namespace stof::host {
namespace {

using test::kNone;

// One row: truth, mask and result of each pixel.
struct DisparityPixel {
  float truth;
  std::uint8_t visible;
  float disparity;
};

struct Row {
  dataset::StereoScene scene;
  dataset::Image<float> disparity;

  explicit Row(const std::vector<DisparityPixel>& pixels)
      : disparity(static_cast<int>(pixels.size()), 1) {
    const int width = disparity.width;
    scene.left = {width, 1};
    scene.right = {width, 1};
    scene.ndisp = 1;
    scene.truth.emplace(width, 1);
    scene.visible.emplace(width, 1);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      scene.truth->pixels[i] = pixels[i].truth;
      scene.visible->pixels[i] = pixels[i].visible;
      disparity.pixels[i] = pixels[i].disparity;
    }
  }
};

TEST(DisparityScore, CountsEveryVariantOfBadPixels) {
  const Row row({
      {10, 255, 10},        // right
      {10, 255, 11},        // exactly one off: not bad
      {10, 255, 11.0625F},  // too large by more than 1
      {10, 255, 8.9375F},   // too small by more than 1: not bad when signed
      {10, 255, kNone},     // missing
      {10, 0, 20},          // occluded, too large
      {10, 0, 1},           // occluded, too small
      {10, 0, kNone},       // occluded, missing
      {kNone, 0, 10},       // without truth
      {kNone, 0, kNone},    // without truth, missing
  });
  const DisparityScore score = score_disparity(row.disparity, row.scene, 1);
  EXPECT_DOUBLE_EQ(score.all.value(), 6.0 / 8);
  EXPECT_DOUBLE_EQ(score.visible.value(), 3.0 / 5);
  EXPECT_DOUBLE_EQ(score.of_valid.value(), 4.0 / 6);
  EXPECT_DOUBLE_EQ(score.signed_all.value(), 4.0 / 8);
  EXPECT_DOUBLE_EQ(score.signed_visible.value(), 2.0 / 5);
  EXPECT_DOUBLE_EQ(score.density, 7.0 / 10);
  EXPECT_DOUBLE_EQ(score.core.value(), 3.0 / 4);  // visible and x >= ndisp = 1: the first is out
}

TEST(DisparityScore, TakesTheCoreBehindTheSearchRangeAndInsideHalfABlock) {
  // 12x10 px, ndisp 4, w 5: margin 2, core is x in 6..9, y in 2..7.
  dataset::StereoScene scene;
  scene.ndisp = 4;
  scene.truth.emplace(12, 10, 7.0F);
  scene.visible.emplace(12, 10, std::uint8_t{1});
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 12; ++x) {
      dataset::Image<float> disparity(12, 10, 7.0F);
      disparity.view().at(x, y) = kNone;  // one bad pixel: counted in the core or not
      const bool inside = x >= 6 && x <= 9 && y >= 2 && y <= 7;
      const DisparityScore score = score_disparity(disparity, scene, 5);
      EXPECT_DOUBLE_EQ(score.core.value(), inside ? 1.0 / 24 : 0) << x << "," << y;
    }
  }
  scene.visible.emplace(12, 10, std::uint8_t{0});
  EXPECT_FALSE(score_disparity(dataset::Image<float>(12, 10, 7.0F), scene, 5).core.has_value());
}

TEST(DisparityScore, LeavesOutWhatASceneWithoutTruthCannotSay) {
  dataset::StereoScene scene;
  const DisparityScore score = score_disparity(dataset::Image<float>(2, 1, 3.0F), scene, 1);
  EXPECT_FALSE(score.all || score.visible || score.core || score.of_valid || score.signed_all);
  EXPECT_DOUBLE_EQ(score.density, 1);
}

TEST(DisparityScore, HasNoShareOfValidPixelsWhereNoneIsValid) {
  const Row row({{10, 255, kNone}});
  const DisparityScore score = score_disparity(row.disparity, row.scene, 1);
  EXPECT_DOUBLE_EQ(score.all.value(), 1);
  EXPECT_FALSE(score.of_valid.has_value());
}

TEST(MeanScore, AveragesOverTheScenesThatHaveTheNumber) {
  std::array<DisparityScore, 3> scores;
  scores[0].all = 0.1;
  scores[0].visible = 0.5;
  scores[0].density = 1;
  scores[1].all = 0.2;
  scores[1].density = 0.5;
  const DisparityScore mean = mean_score(scores);
  EXPECT_DOUBLE_EQ(mean.all.value(), 0.15);
  EXPECT_DOUBLE_EQ(mean.visible.value(), 0.5);
  EXPECT_FALSE(mean.core.has_value());
  EXPECT_DOUBLE_EQ(mean.density, 0.5);
}

TEST(ToPixels, KeepsSixteenthsAndTurnsNoneIntoInfinity) {
  const std::array<dsp::Disparity, 4> raw{dsp::Disparity::from_raw(0),
                                          dsp::Disparity::from_raw(-17), dsp::Disparity::none(),
                                          dsp::Disparity::from_pixels(63)};
  const dataset::Image<float> pixels =
      to_pixels(dsp::ImageView<const dsp::Disparity>(raw.data(), 2, 2));
  EXPECT_EQ(pixels.pixels, (std::vector<float>{0, -1.0625F, kNone, 63}));
}

TEST(DisparityScore, CountsSeenPixelsWithinNineOfAStepOfMoreThanTwo) {
  std::vector<DisparityPixel> pixels(40, {4, 255, 4});
  for (std::size_t x = 20; x < 40; ++x) {
    pixels[x] = {6.5F, 255, 6.5F};  // the step lies between columns 19 and 20
  }
  pixels[10].disparity = 9;  // nine columns from 19: counted
  pixels[29].disparity = kNone;
  pixels[9].disparity = 9;  // one too far
  pixels[30].disparity = 9;
  pixels[15] = {4, 0, 9};  // occluded
  const Row row(pixels);
  EXPECT_DOUBLE_EQ(score_disparity(row.disparity, row.scene, 1).near_edges.value(), 2.0 / 19);
}

TEST(DisparityScore, FindsNoEdgeInSmallStepsAndUnknownTruth) {
  const Row row({{4, 255, 9}, {6, 255, 9}, {8, 255, 9}, {kNone, 0, 9}, {20, 255, 9}});
  EXPECT_FALSE(score_disparity(row.disparity, row.scene, 1).near_edges.has_value());
}

TEST(NearDiscontinuities, ReachNineRowsAndColumnsFromEitherSide) {
  dataset::Image<float> truth(40, 40, 2.0F);
  truth.view().at(20, 20) = 10;
  const dataset::Image<std::uint8_t> mask = near_discontinuities(truth);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      // The neighbours across the step are at distance 1 of (20, 20), in one direction.
      const int dx = std::abs(x - 20);
      const int dy = std::abs(y - 20);
      const bool near = std::min(dx, dy) <= 9 && std::max(dx, dy) <= 10;
      EXPECT_EQ(mask.view().at(x, y), near ? 255 : 0) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace stof::host
