#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "host/calibrate/report/pmd_json.h"
#include "host/calibrate/report/pmd_report.h"
#include "tests/support/recorded_scenes.h"

// On the recorded walls, where they are: the folder named by STOF_DATA. The tool's own bars.
namespace stof::host {
namespace {

class RecordedWalls : public test::RecordedScenes {
 protected:
  struct Judged {
    PmdCalibration calibration;
    PmdReport report;
  };
  Judged calibrate(const char* name, Frames frames, const CalibrateOptions& options) const {
    dataset::Loaded<WallFolder> folder = read_folder(sim_ / name, frames);
    EXPECT_TRUE(folder) << folder.error().message;
    dataset::Loaded<PmdCalibration> found =
        calibrate_pmd(folder->calibration.pmd, std::move(folder->walls), options);
    EXPECT_TRUE(found) << found.error().message;
    dataset::Loaded<PmdReport> report = make_report(*folder, frames, *found);
    EXPECT_TRUE(report) << report.error().message;
    return {.calibration = std::move(*found), .report = std::move(*report)};
  }

  static CalibrateOptions everything() {
    return {.parts = {.emitter = true, .wall_turn = true},
            .start = std::nullopt,
            .phase_falls = std::nullopt};
  }

  const std::filesystem::path sim_ = test::recorded_scenes() / "tof" / "sim";
};

void expect_within(const PmdReport& report, double from_m, double relative) {
  int judged = 0;
  for (const WallRow& row : report.rows) {
    if (row.z_m >= from_m) {
      EXPECT_LE(std::abs(row.view.error_m), relative * row.z_m) << row.name;
      ++judged;
    }
  }
  EXPECT_GE(judged, 4);
}

TEST_F(RecordedWalls, CalibratedOnHalfTheFramesTheOthersAreRightWithinAThousandth) {
  for (const Frames frames : {Frames::kEven, Frames::kOdd}) {
    const Judged judged = calibrate("wall", frames, everything());
    expect_within(judged.report, 1.5, 0.001);
    EXPECT_EQ(judged.calibration.stray.verdict, StrayVerdict::kNone);
    EXPECT_EQ(judged.calibration.model.scale, 1);
  }
}

TEST_F(RecordedWalls, AStraightLineAloneLeavesWhatTheChapterHad) {
  const Judged judged = calibrate("wall", Frames::kAll, everything());
  ASSERT_TRUE(judged.calibration.line);
  EXPECT_GT(judged.calibration.line->worst_relative, 0.015);
  EXPECT_LT(judged.calibration.line->worst_relative, 0.03);
  EXPECT_NEAR(judged.calibration.line->slope_cm, -5.4022, 0.06);
}

TEST_F(RecordedWalls, SigmaIsTheSpreadOverFrames) {
  const Judged judged = calibrate("wall", Frames::kEven, everything());
  ASSERT_TRUE(judged.calibration.sigma);
  for (const WallRow& row : judged.report.rows) {
    if (row.z_m < 1) {
      continue;
    }
    EXPECT_NEAR(row.view.predicted_m / row.view.spread_m, 1, 0.15) << row.name;
    if (row.exposure == 1) {
      EXPECT_NEAR(sigma_at(*judged.calibration.sigma, row.z_m) / row.view.spread_m, 1, 0.15)
          << row.name;
    }
  }
}

TEST_F(RecordedWalls, StrayLightIsFoundTogetherWithEverythingElse) {
  const Judged judged = calibrate("stray", Frames::kAll, everything());
  EXPECT_EQ(judged.calibration.stray.verdict, StrayVerdict::kCorrected);
  expect_within(judged.report, 1, 0.01);
}

TEST_F(RecordedWalls, StrayLightIsFoundWithWhatTheWallsKnow) {
  const Judged walls = calibrate("wall", Frames::kAll, everything());
  CalibrateOptions options = everything();
  options.start = walls.calibration.sensor;
  options.parts = {.offset = false, .scale = false, .wiggling = false, .pattern = false};
  const Judged judged = calibrate("stray", Frames::kAll, options);
  EXPECT_EQ(judged.calibration.stray.verdict, StrayVerdict::kCorrected);
  expect_within(judged.report, 1, 0.01);
}

TEST_F(RecordedWalls, StrayLightThatStaysIsSuspected) {
  CalibrateOptions options = everything();
  options.parts = {
      .offset = true, .scale = true, .wiggling = false, .pattern = false, .stray = false};
  const Judged judged = calibrate("stray", Frames::kAll, options);
  EXPECT_EQ(judged.calibration.stray.verdict, StrayVerdict::kSuspected);
  EXPECT_GT(judged.report.worst_relative, 0.05);
  const std::string text = report_text(judged.report, judged.calibration);
  EXPECT_NE(text.find("stray light suspected"), std::string::npos);
  EXPECT_NE(report_json(judged.report, judged.calibration).find("\"stray_suspected\": true"),
            std::string::npos);
}

TEST_F(RecordedWalls, TheLightBesideTheLensIsFoundWhereNobodySaysWhereItIs) {
  dataset::Loaded<WallFolder> folder = read_folder(sim_ / "emitter", Frames::kAll);
  ASSERT_TRUE(folder) << folder.error().message;
  dsp::PmdSensor camera = folder->calibration.pmd;
  ASSERT_EQ(camera.emitter_count, 1);
  const dsp::Emitter truth = camera.emitters[0];
  camera.emitter_count = 0;
  const dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(camera, std::move(folder->walls), everything());
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->model.emitters.size(), 1U);
  EXPECT_NEAR(found->model.emitters[0][0], truth[0], 0.03);
  EXPECT_NEAR(found->model.emitters[0][1], truth[1], 0.03);
}

}  // namespace
}  // namespace stof::host
