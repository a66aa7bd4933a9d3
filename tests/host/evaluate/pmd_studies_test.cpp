#include <cmath>
#include <fstream>

#include "host/evaluate/pmd/figures.h"
#include "host/evaluate/pmd/print/json.h"
#include "host/evaluate/pmd/print/text.h"
#include "tests/dataset/scratch.h"
#include "tests/host/evaluate/pmd_recordings.h"

// Studies of recordings of which the truth is known to the test.
namespace stof::host {
namespace {

using test::Board;
using test::record;
using test::SimulatedCamera;

class PmdStudies : public test::Scratch {
 protected:
  void put_walls(const std::vector<double>& z_m, const std::string& more = "") const {
    for (const double z : z_m) {
      test::put_wall(folder(), record(camera_, z, 8, 11), test::noise_of(camera_) + more);
    }
  }
  PmdEvaluation evaluate() const {
    dataset::Loaded<PmdEvaluation> found =
        evaluate_pmd({.folder = folder(), .calibration = {}, .phase_samples = 1000});
    if (!found) {
      ADD_FAILURE() << found.error().message;
      return {};
    }
    return std::move(*found);
  }
  SimulatedCamera camera_;
};

TEST_F(PmdStudies, ACalibrationLeavesLessOfAWallsErrorThanALine) {
  camera_.wiggling.sine[3] = 0.05;
  camera_.offset_m = 0.1;
  camera_.pattern_m = 0.004;
  put_walls({1, 1.3, 1.6, 1.9, 2.2, 2.6, 3, 3.5, 4});
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.walls.size(), 1U);
  const WallStudy& study = found.walls[0];
  EXPECT_TRUE(study.stray.empty());
  EXPECT_EQ(study.report.judged, Frames::kOdd);
  EXPECT_LT(study.report.worst_relative, 0.005);
  ASSERT_TRUE(study.calibration.line);
  EXPECT_GT(study.calibration.line->worst_relative, 0.01);
  EXPECT_EQ(study.report.rows.size(), 9U);
}

TEST_F(PmdStudies, StrayLightIsFoundAndSubtracted) {
  camera_.stray = {40, 110};
  put_walls({1, 1.5, 2, 2.5, 3, 3.5, 4});
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.walls.size(), 1U);
  const WallStudy& study = found.walls[0];
  ASSERT_EQ(study.stray.size(), 7U);
  EXPECT_NEAR(study.stray_i_lsb, 40, 3);
  EXPECT_NEAR(study.stray_q_lsb, 110, 3);
  for (const StrayRow& row : study.stray) {
    if (row.z_m > 1.5) {
      EXPECT_GT(std::abs(row.before.error_m), 5 * std::abs(row.after.error_m)) << row.name;
    }
  }
}

TEST_F(PmdStudies, TheNearModelPaysWhereTheLightIsBesideTheLens) {
  camera_.emitters = {{0.15, 0, 0}};
  camera_.white_lsb = 400;
  put_walls({0.7, 1, 1.5}, ", \"emitters\": [[0.15, 0, 0]]");
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.lights.size(), 1U);
  ASSERT_EQ(found.lights[0].rows.size(), 3U);
  for (const LightRow& row : found.lights[0].rows) {
    EXPECT_GT(row.before_blocks_m, 0.01) << row.z_m;
    EXPECT_LT(row.after_blocks_m, row.before_blocks_m / 4) << row.z_m;
    EXPECT_GT(row.pixels, 700) << row.z_m;
  }
}

TEST_F(PmdStudies, IntervalsOfMixedPixelsHoldBothSurfaces) {
  camera_.white_lsb = 120;  // noise is above the slope of the walls
  for (const double share : {0.2, 0.5, 0.8}) {
    test::write_edge(folder(), "s" + std::to_string(std::lround(10 * share)), camera_,
                     Board{.share = share});
  }
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.edges.size(), 1U);
  const EdgeCounts& all = found.edges[0].all;
  EXPECT_EQ(all.mixed, 3 * 4 * camera_.lens.height);
  EXPECT_EQ(all.mixed_with_depth, all.mixed);
  EXPECT_EQ(all.holding, all.mixed);
  EXPECT_EQ(all.mixed_flagged, all.mixed);
  EXPECT_EQ(all.worst_m, 0);
  // Far from the edge nothing is flagged.
  EXPECT_LT(all.pure_flagged - all.pure_flagged_beside, all.pure_with_depth / 100);
}

TEST_F(PmdStudies, AnIntervalThatMissesASurfaceIsCounted) {
  test::write_edge(folder(), "edge", camera_, Board{});
  // The truth says that the far surface is a metre further than the camera saw.
  std::vector<double> farthest = test::radial(camera_, 3.2);
  const std::vector<double> board = test::radial(camera_, 1);
  for (std::size_t i = 0; i < farthest.size(); ++i) {
    farthest[i] = static_cast<int>(i) % camera_.lens.width < 16 ? board[i] : farthest[i];
  }
  test::write_map(folder() / "edge_r_max.pgm", camera_, farthest);
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.edges.size(), 1U);
  EXPECT_GT(found.edges[0].all.mixed_with_depth, 0);
  EXPECT_EQ(found.edges[0].all.holding, 0);
  EXPECT_NEAR(found.edges[0].all.worst_m, 0.9, 0.3);
}

TEST_F(PmdStudies, ATurnThatIsWrongIsCounted) {
  camera_.white_lsb = 20'000;  // long enough for 8 m
  for (const int mhz : {30, 25}) {
    camera_.f_mod_hz = static_cast<std::uint32_t>(mhz) * 1'000'000;
    host::WallRecording wall = record(camera_, 8, 2, 3);
    wall.name = "f" + std::to_string(mhz);
    test::put_wall(folder(), wall, test::noise_of(camera_) + ", \"pair\": [30e6, 25e6]");
  }
  // The truth says 4 m: no reading is right.
  test::write_map(folder() / "f30_r_med.pgm", camera_, test::radial(camera_, 4));
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.frequencies.size(), 1U);
  const FrequencyRow& row = found.frequencies[0].rows.at(0);
  EXPECT_NEAR(row.period_m, 29.98, 0.01);
  EXPECT_GT(row.accepted, row.pixels / 2);
  EXPECT_EQ(row.wrong, row.accepted);
}

TEST_F(PmdStudies, ATurnThatIsRightIsNotCountedAsWrong) {
  for (const int mhz : {30, 25}) {
    camera_.f_mod_hz = static_cast<std::uint32_t>(mhz) * 1'000'000;
    camera_.white_lsb = 15'000;
    host::WallRecording wall = record(camera_, 6, 2, 3);
    wall.name = "f" + std::to_string(mhz);
    test::put_wall(folder(), wall, test::noise_of(camera_) + ", \"pair\": [30e6, 25e6]");
  }
  test::write_map(folder() / "f30_r_med.pgm", camera_, test::radial(camera_, 6));
  const PmdEvaluation found = evaluate();
  ASSERT_EQ(found.frequencies.size(), 1U);
  const FrequencyRow& row = found.frequencies[0].rows.at(0);
  EXPECT_GT(row.accepted, row.pixels * 9 / 10);
  EXPECT_EQ(row.wrong, 0);
  EXPECT_LT(row.median_error_m, 0.02);
}

TEST_F(PmdStudies, SaysWhatIsAbsentAndWritesEveryPart) {
  test::write_edge(folder(), "edge", camera_, Board{});
  const PmdEvaluation found = evaluate();
  const std::string text = pmd_text(found);
  EXPECT_NE(text.find("absent: two modulation frequencies"), std::string::npos) << text;
  EXPECT_EQ(text.find("absent: an edge"), std::string::npos) << text;
  EXPECT_NE(pmd_json(found).find("\"holds_both\": 1.0"), std::string::npos);
}

TEST_F(PmdStudies, RefusesACalibrationThatIsNone) {
  test::write_edge(folder(), "edge", camera_, Board{});
  const std::filesystem::path file = put("rig.cal", "nothing");
  const dataset::Loaded<PmdEvaluation> found =
      evaluate_pmd({.folder = folder(), .calibration = file});
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find(file.string()), std::string::npos) << found.error().message;
}

}  // namespace
}  // namespace stof::host
