#include "host/evaluate/fusion/depth_score.h"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/no_value.h"

namespace stof::host {
namespace {

using test::kNone;

struct DepthPixel {
  float truth;
  float depth;
  float low;
  float high;
};

DepthScore score_of(const std::vector<DepthPixel>& pixels) {
  const int width = static_cast<int>(pixels.size());
  DepthPlanes planes{.depth = {width, 1}, .low = {width, 1}, .high = {width, 1}};
  dataset::Image<float> truth(width, 1);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    truth.pixels[i] = pixels[i].truth;
    planes.depth.pixels[i] = pixels[i].depth;
    planes.low.pixels[i] = pixels[i].low;
    planes.high.pixels[i] = pixels[i].high;
  }
  return score_depth(planes, truth);
}

TEST(DepthScore, AnswersAMapWorkedOutByHand) {
  const DepthScore score = score_of({
      {2, 2, 1.75F, 2.25F},              // right, hit, width 0.5
      {2, 2.0625F, 2.03125F, 2.09375F},  // 3 % off, the interval misses, width 0.0625
      {4, 4.25F, 4, 4.5F},       // 6 % off: bad; the truth is the lower bound: hit, width 0.5
      {4, kNone, kNone, kNone},  // missing
      {kNone, 3, 2, 4},          // without truth: does not count
  });
  EXPECT_EQ(score.truth_pixels, 4U);
  EXPECT_DOUBLE_EQ(score.e5, 2.0 / 4);
  EXPECT_DOUBLE_EQ(score.coverage, 3.0 / 4);
  EXPECT_DOUBLE_EQ(score.median_error_m.value(), 0.0625);
  EXPECT_DOUBLE_EQ(score.median_relative.value(), 0.03125);
  EXPECT_DOUBLE_EQ(score.hit_rate.value(), 2.0 / 3);
  EXPECT_DOUBLE_EQ(score.median_width_m.value(), 0.5);
  EXPECT_DOUBLE_EQ(score.median_width_relative.value(), 0.125);  // of 0.25, 0.03125, 0.125
}

TEST(DepthScore, CountsHitsInEachQuarterOfTheWidths) {
  std::vector<DepthPixel> pixels;
  for (const float width : {0.5F, 0.25F, 0.125F, 0.0625F}) {
    pixels.push_back({2, 2, 2 - width / 2, 2 + width / 2});  // a hit
    const bool also_hit = width == 0.125F;
    const float truth = also_hit ? 3.0F : 4.0F;
    pixels.push_back({truth, 3, 3 - width / 2, 3 + width / 2});
  }
  const DepthScore score = score_of(pixels);
  EXPECT_DOUBLE_EQ(score.hit_rate.value(), 5.0 / 8);
  EXPECT_DOUBLE_EQ(score.hit_rate_by_width[0].value(), 0.5);  // the narrowest two
  EXPECT_DOUBLE_EQ(score.hit_rate_by_width[1].value(), 1);
  EXPECT_DOUBLE_EQ(score.hit_rate_by_width[2].value(), 0.5);
  EXPECT_DOUBLE_EQ(score.hit_rate_by_width[3].value(), 0.5);
}

TEST(HitRatesByWidth, KeepTheOrderOfEqualWidthsAndSayNothingOfEmptyParts) {
  const std::vector<IntervalCheck> checks{{1, true}, {1, true}, {1, false}, {0.5, false}};
  EXPECT_EQ(hit_rates_by_width(checks, 2), (std::vector<std::optional<double>>{0.5, 0.5}));
  EXPECT_EQ(hit_rates_by_width({{{1, true}}}, 2),
            (std::vector<std::optional<double>>{std::nullopt, 1.0}));
  EXPECT_EQ(hit_rates_by_width({}, 1), (std::vector<std::optional<double>>{std::nullopt}));
}

TEST(MeanScore, LeavesOutWhatAScoreDoesNotHave) {
  const std::array<DepthScore, 2> scores{score_of({{2, 2, 1.75F, 2.25F}}),
                                         score_of({{2, kNone, kNone, kNone}})};
  const DepthScore mean = mean_score(scores);
  EXPECT_EQ(mean.truth_pixels, 2U);
  EXPECT_DOUBLE_EQ(mean.e5, 0.5);
  EXPECT_DOUBLE_EQ(mean.coverage, 0.5);
  EXPECT_DOUBLE_EQ(mean.median_width_m.value(), 0.5);
  EXPECT_DOUBLE_EQ(mean.median_width_relative.value(), 0.25);
  EXPECT_DOUBLE_EQ(mean.hit_rate.value(), 1);
  EXPECT_FALSE(mean_score({}).hit_rate);
}

TEST(DepthScore, CallsFivePercentRightAndMoreWrong) {
  EXPECT_DOUBLE_EQ(score_of({{2, 2.0999F, 2, 3}}).e5, 0);
  EXPECT_DOUBLE_EQ(score_of({{2, 2.1001F, 2, 3}}).e5, 1);
  EXPECT_DOUBLE_EQ(score_of({{2, 1.9001F, 2, 3}}).e5, 0);
  EXPECT_DOUBLE_EQ(score_of({{2, 1.8999F, 2, 3}}).e5, 1);
}

TEST(DepthScore, OfAnEmptyMapIsAllMissing) {
  const DepthScore score = score_of({{2, kNone, kNone, kNone}, {3, kNone, kNone, kNone}});
  EXPECT_DOUBLE_EQ(score.e5, 1);
  EXPECT_DOUBLE_EQ(score.coverage, 0);
  EXPECT_FALSE(score.median_error_m || score.hit_rate || score.median_width_m ||
               score.median_relative);
}

TEST(ToMetres, PutsTheDepthInTheMiddleOfItsInterval) {
  const std::array<dsp::QuarterMm, 3> depth{4000, 0, 65535};
  const std::array<dsp::QuarterMm, 3> width{100, 50, 1};
  const DepthPlanes planes = to_metres({depth.data(), 3, 1}, {width.data(), 3, 1});
  EXPECT_EQ(planes.depth.pixels[0], 1.0F);
  EXPECT_EQ(planes.low.pixels[0], 0.9875F);
  EXPECT_EQ(planes.high.pixels[0], 1.0125F);
  EXPECT_EQ(planes.depth.pixels[1], kNone);
  EXPECT_EQ(planes.low.pixels[1], kNone);
  EXPECT_EQ(planes.high.pixels[1], kNone);
  EXPECT_EQ(planes.depth.pixels[2], 16.38375F);
  EXPECT_EQ(planes.low.pixels[2], 65534.5F / 4000);
}

TEST(DepthFromDisparity, FollowsTheRigsFormula) {
  const dsp::StereoRig rig{
      .left = {.width = 4, .height = 1, .fx = 1000, .fy = 1000}, .baseline_m = 0.2, .doff_px = -10};
  dataset::Image<float> disparity(4, 1);
  disparity.pixels = {50, kNone, 10, 5};
  const dataset::Image<float> depth = depth_from_disparity(disparity, rig);
  EXPECT_EQ(depth.pixels,
            (std::vector<float>{5, kNone, kNone, kNone}));  // 200 / 40; then behind the rig
}

}  // namespace
}  // namespace stof::host
