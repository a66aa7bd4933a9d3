#include "host/evaluate/floor/floor_score.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "host/evaluate/floor/floor_case.h"
#include "tests/support/no_value.h"

namespace stof::host {
namespace {

using dataset::Surface;
using test::kNone;

// One column of a camera 1 m above a floor that looks straight ahead: its rows see the floor at 5,
// 3.3, 2.5, 2 and 1.7 m.
constexpr int kRows = 5;
constexpr dsp::Pinhole kLens{.width = 1, .height = kRows, .fx = 10, .fy = 10, .cx = 0, .cy = -2};

double floor_depth(double below, int row) { return below * kLens.fy / (row - kLens.cy); }

struct World {
  dataset::FloorTruth floor{
      .height_m = 1, .tilt_degrees = 0, .surface = {1, kRows, Surface::kFloor}};
  dataset::Image<std::uint8_t> visible{1, kRows, 255};
  dataset::Image<float> truth{1, kRows};
  World() {
    for (int y = 0; y < kRows; ++y) {
      truth.pixels[static_cast<std::size_t>(y)] = static_cast<float>(floor_depth(1, y));
    }
  }
  FloorScore score(const std::vector<float>& depth,
                   std::span<const dsp::Source> source = {}) const {
    dataset::Image<float> map(1, kRows);
    map.pixels = depth;
    return score_floor(map, source,
                       {.floor = floor, .visible = visible, .depth = truth, .lens = kLens});
  }
};

std::vector<float> times(const std::vector<float>& depth, float factor) {
  std::vector<float> out;
  for (const float z : depth) {
    out.push_back(factor * z);
  }
  return out;
}

TEST(FloorScore, OfTheTruthIsFreeOfFaults) {
  const World world;
  const FloorScore score = world.score(world.truth.pixels);
  const SurfaceScore& floor = score.of(Surface::kFloor);
  EXPECT_EQ(floor.pixels, 4U);  // at 5 m is too far away to count
  EXPECT_EQ(floor.off, 0);
  EXPECT_EQ(floor.missing, 0);
  EXPECT_EQ(floor.median_error_m, 0);
  EXPECT_EQ(floor.p95_error_m, 0);
  EXPECT_EQ(score.missing_anywhere, 0);
  EXPECT_EQ(score.obstacle, 0);
  EXPECT_EQ(score.of(Surface::kBox).pixels, 0U);
  EXPECT_FALSE(score.of(Surface::kBox).off);
  EXPECT_FALSE(score.no_drop);
  EXPECT_FALSE(score.conflict);
}

TEST(FloorScore, TenPercentTooFarIsOffAndNoObstacle) {
  const World world;
  const FloorScore score = world.score(times(world.truth.pixels, 1.1F));
  const SurfaceScore& floor = score.of(Surface::kFloor);
  EXPECT_EQ(floor.off, 1);
  EXPECT_EQ(floor.missing, 0);
  // A tenth of 10/3, 2.5, 2 and 10/6 m.
  EXPECT_NEAR(floor.median_error_m.value(), 0.225, 1e-6);
  EXPECT_NEAR(floor.p95_error_m.value(), 1.0 / 3, 1e-6);
  EXPECT_EQ(score.obstacle, 0);
}

TEST(FloorScore, WhatIsTooNearStandsAboveTheFloor) {
  const World world;
  // Of a camera at 1 m, z times 0.98 is 2 cm above the floor, z times 0.96 is 4 cm above it.
  EXPECT_EQ(world.score(times(world.truth.pixels, 0.98F)).obstacle, 0);
  const FloorScore higher = world.score(times(world.truth.pixels, 0.96F));
  EXPECT_EQ(higher.obstacle, 1);
  EXPECT_EQ(higher.of(Surface::kFloor).off, 0);
}

TEST(FloorScore, NoDepthIsMissingAndNothingElse) {
  const World world;
  const FloorScore score = world.score(std::vector<float>(kRows, kNone));
  const SurfaceScore& floor = score.of(Surface::kFloor);
  EXPECT_EQ(floor.off, 0);
  EXPECT_EQ(floor.missing, 1);
  EXPECT_FALSE(floor.median_error_m);
  EXPECT_FALSE(floor.p95_error_m);
  EXPECT_EQ(score.obstacle, 0);
  EXPECT_EQ(score.missing_anywhere, 1);
}

TEST(FloorScore, KnowsTheTiltOfTheCamera) {
  World world;
  world.floor.tilt_degrees = 30;
  const double y = (4 - kLens.cy) / kLens.fy;
  const double depth = 1 / (y * std::cos(std::numbers::pi / 6) + 0.5);
  world.truth.pixels[4] = static_cast<float>(depth);
  world.floor.surface.pixels.assign(kRows, Surface::kOther);
  world.floor.surface.pixels[4] = Surface::kFloor;
  std::vector<float> measured = world.truth.pixels;
  EXPECT_EQ(world.score(measured).obstacle, 0);
  measured[4] *= 0.965F;  // 3.5 cm
  EXPECT_EQ(world.score(measured).obstacle, 1);
}

TEST(FloorScore, CountsHiddenPixelsOnlyAsMissingAnywhere) {
  World world;
  world.visible.pixels[1] = 0;
  std::vector<float> depth = world.truth.pixels;
  depth[1] = kNone;
  const FloorScore score = world.score(depth);
  EXPECT_EQ(score.of(Surface::kFloor).pixels, 3U);
  EXPECT_EQ(score.of(Surface::kFloor).missing, 0);
  EXPECT_EQ(score.missing_anywhere, 0.25);
}

TEST(FloorScore, LeavesOutWhatHasNoTruth) {
  World world;
  world.truth.pixels[3] = kNone;
  EXPECT_EQ(world.score(world.truth.pixels).of(Surface::kFloor).pixels, 3U);
}

TEST(FloorScore, LowerFloorAtTheHeightOfTheFloorIsNoDrop) {
  World world;
  for (const int row : {2, 3, 4}) {
    const std::size_t i = static_cast<std::size_t>(row);
    world.floor.surface.pixels[i] = Surface::kLowerFloor;
    world.truth.pixels[i] = static_cast<float>(floor_depth(1.1, row));
  }
  std::vector<float> depth = world.truth.pixels;
  EXPECT_EQ(world.score(depth).no_drop, 0);
  depth[2] = static_cast<float>(floor_depth(1, 2));     // as if the floor went on
  depth[3] = static_cast<float>(floor_depth(1.06, 3));  // more than half of the drop is seen
  depth[4] = kNone;                                     // unknown is no way
  const FloorScore score = world.score(depth);
  EXPECT_DOUBLE_EQ(score.no_drop.value(), 1.0 / 3);
  // As if the floor went on is 9 percent too near.
  EXPECT_DOUBLE_EQ(score.of(Surface::kLowerFloor).off.value(), 1.0 / 3);
}

TEST(FloorScore, OfGlassTellsWrongFromNoneAndConflict) {
  World world;
  world.floor.surface.pixels.assign(kRows, Surface::kGlass);
  std::vector<float> depth = times(world.truth.pixels, 1.5F);
  depth[0] = kNone;
  depth[1] = kNone;
  using dsp::Source;
  const FloorScore score = world.score(
      depth,
      std::vector{Source::kConflict, Source::kNone, Source::kStereo, Source::kPmd, Source::kBoth});
  EXPECT_DOUBLE_EQ(score.of(Surface::kGlass).off.value(), 0.6);
  EXPECT_DOUBLE_EQ(score.of(Surface::kGlass).missing.value(), 0.4);
  EXPECT_DOUBLE_EQ(score.conflict.value(), 0.2);
}

TEST(FloorScore, MeanLeavesOutWhatAScoreDoesNotHave) {
  const World world;
  const std::array scores{world.score(world.truth.pixels),
                          world.score(std::vector<float>(kRows, kNone))};
  const FloorScore mean = mean_score(std::span<const FloorScore>(scores));
  EXPECT_EQ(mean.of(Surface::kFloor).pixels, 8U);
  EXPECT_EQ(mean.of(Surface::kFloor).missing, 0.5);
  EXPECT_EQ(mean.of(Surface::kFloor).median_error_m, 0);
  EXPECT_EQ(mean.missing_anywhere, 0.5);
  EXPECT_FALSE(mean.no_drop);
}

TEST(RelativeError, IsSignedAndUnknownWhereOneIs) {
  dataset::Image<float> depth(3, 1);
  dataset::Image<float> truth(3, 1, 2);
  depth.pixels = {2.5F, 1.5F, kNone};
  EXPECT_EQ(relative_error(depth, truth).pixels, (std::vector<float>{0.25F, -0.25F, kNone}));
  truth.pixels[0] = kNone;
  EXPECT_EQ(relative_error(depth, truth).pixels[0], kNone);
}

}  // namespace
}  // namespace stof::host
