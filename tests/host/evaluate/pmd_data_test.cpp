#include <cstdlib>

#include <gtest/gtest.h>

#include "host/evaluate/pmd/figures.h"
#include "tests/support/recorded_scenes.h"

// The figures of the recorded frames: the folder named by STOF_DATA.
namespace stof::host {
namespace {

class PmdData : public test::RecordedScenes {
 protected:
  // Made once for all tests; empty where it cannot be.
  static const PmdEvaluation& found() {
    static const dataset::Loaded<PmdEvaluation> made =
        evaluate_pmd({.folder = test::recorded_scenes() / "tof", .calibration = {}});
    static const PmdEvaluation nothing;
    EXPECT_TRUE(made) << made.error().message;
    return made ? *made : nothing;
  }
};

TEST_F(PmdData, PhaseIsWithinOneLsb) {
  EXPECT_LE(found().phase.largest_lsb, 1);
  EXPECT_TRUE(found().phase.kernels_equal);
}

TEST_F(PmdData, WallsAreWithinAPercentOnceCalibratedAndSigmaIsHonest) {
  int walls = 0;
  for (const WallStudy& study : found().walls) {
    for (const WallRow& row : study.report.rows) {
      if (row.view.valid < 0.5) {
        continue;
      }
      EXPECT_LE(std::abs(row.view.error_m), 0.01 * row.z_m) << row.name;
      if (study.stray.empty()) {
        EXPECT_NEAR(row.view.predicted_m / row.view.spread_m, 1, 0.2) << row.name;
        ++walls;
      }
    }
  }
  EXPECT_GE(walls, 12);
}

TEST_F(PmdData, EveryMixedPixelWithADepthHoldsBothSurfaces) {
  ASSERT_FALSE(found().edges.empty());
  for (const EdgeStudy& study : found().edges) {
    EXPECT_GT(study.all.mixed_with_depth, 0);
    EXPECT_EQ(study.all.holding, study.all.mixed_with_depth);
    EXPECT_GE(5 * study.all.mixed_flagged, 4 * study.all.mixed_with_depth);
    EXPECT_LE(20 * study.all.pure_flagged, study.all.pure_with_depth);
  }
}

TEST_F(PmdData, TheNearModelLeavesFiveMillimetres) {
  ASSERT_FALSE(found().lights.empty());
  for (const LightRow& row : found().lights[0].rows) {
    EXPECT_LE(row.after_blocks_m, 0.005) << row.name;
    EXPECT_GE(row.before_blocks_m, 0.015) << row.name;
  }
}

TEST_F(PmdData, NoTurnOfTwoFrequenciesIsWrong) {
  ASSERT_FALSE(found().frequencies.empty());
  for (const FrequencyRow& row : found().frequencies[0].rows) {
    EXPECT_EQ(row.wrong, 0) << row.name;
    EXPECT_GE(row.accepted, row.pixels / 2) << row.name;
  }
}

TEST_F(PmdData, TheCamerasFrameBecomesACloudWithinAMillimetre) {
  ASSERT_FALSE(found().frames.empty());
  const FrameStudy& frame = found().frames[0];
  EXPECT_TRUE(frame.same_distances);
  EXPECT_LE(frame.exact.largest_m, 0.001);
  EXPECT_GE(frame.rank_correlation, 0.5);
}

}  // namespace
}  // namespace stof::host
