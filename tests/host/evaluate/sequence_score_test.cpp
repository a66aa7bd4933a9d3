#include "host/evaluate/sequence/sequence_score.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/no_value.h"

namespace stof::test {
namespace {

using namespace host;
using test::kNone;

// Frames of a few pixels; depths and truths frame after frame.
SequenceScore score(const std::vector<std::vector<float>>& depths,
                    const std::vector<std::vector<float>>& truths, int warm_up = 0) {
  SequenceScorer scorer(warm_up);
  for (std::size_t t = 0; t < depths.size(); ++t) {
    const int width = static_cast<int>(depths[t].size());
    dataset::Image<float> depth(width, 1);
    dataset::Image<float> truth(width, 1);
    depth.pixels = depths[t];
    truth.pixels = truths[t < truths.size() ? t : truths.size() - 1];
    scorer.add({.depth = depth, .low = depth, .high = depth}, truth);
  }
  return scorer.score();
}

TEST(SequenceScore, CountsFlickerAndJumpsOfSixFrames) {
  std::vector<std::vector<float>> depths(6, {2, 2, 2, 2, kNone});
  depths[3][1] = kNone;  // flickers
  depths[1][2] = 2.6F;   // jumps
  depths[2][3] = kNone;  // both
  depths[3][3] = 1.4F;
  const SequenceScore found = score(depths, {{2, 2, 2, 2, 2}});
  EXPECT_DOUBLE_EQ(*found.flicker, 2.0 / 5);
  EXPECT_DOUBLE_EQ(*found.jumps, 2.0 / 5);
  EXPECT_DOUBLE_EQ(found.depth.coverage, (6 + 5 + 6 + 5) / 30.0);
  EXPECT_FALSE(found.moving_e5);
  EXPECT_FALSE(found.stays[0]);
}

TEST(SequenceScore, LooksBackAtTheFirstFramesOnly) {
  std::vector<std::vector<float>> depths(8, {2});
  depths[0][0] = kNone;
  depths[1][0] = 5;
  EXPECT_DOUBLE_EQ(*score(depths, {{2}}, 2).flicker, 0);
  EXPECT_DOUBLE_EQ(*score(depths, {{2}}, 2).jumps, 0);
  EXPECT_FALSE(score(depths, {{2}}, 3).flicker);  // five frames are no window
  EXPECT_DOUBLE_EQ(*score(depths, {{2}}).flicker, 1);
}

TEST(SequenceScore, NoiseIsTheDeviationFromThePixelsMean) {
  const SequenceScore found = score({{2.1F}, {1.9F}, {2.1F}, {1.9F}, {2.1F}, {1.9F}}, {{2}});
  EXPECT_NEAR(*found.noise_m, 0.1, 1e-6);
}

TEST(SequenceScore, SaysHowLongWhatHasLeftIsShown) {
  // A box at 2 m before a wall at 4 m is taken away in the fourth frame. One pixel shows it for two
  // frames more, one shows nothing, one what is behind.
  const std::vector<std::vector<float>> truths{{2, 2, 2}, {2, 2, 2}, {2, 2, 2}, {4, 4, 4},
                                               {4, 4, 4}, {4, 4, 4}, {4, 4, 4}};
  const std::vector<std::vector<float>> depths{{2, 2, 2},     {2, 2, 2}, {2, 2, 2}, {2, kNone, 4},
                                               {2, kNone, 4}, {4, 4, 4}, {4, 4, 4}};
  const SequenceScore found = score(depths, truths);
  EXPECT_DOUBLE_EQ(*found.stays[0], 1.0 / 3);
  EXPECT_DOUBLE_EQ(*found.stays[1], 1.0 / 3);
  EXPECT_DOUBLE_EQ(*found.stays[2], 0);
  EXPECT_DOUBLE_EQ(*found.moving_e5, 4.0 / 12);
  EXPECT_FALSE(found.flicker);  // the truth moves within the six frames
}

}  // namespace
}  // namespace stof::test
