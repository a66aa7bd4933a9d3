#include "host/cli/calib.h"

#include <cmath>
#include <fstream>

#include "dataset/files/file.h"
#include "host/calibrate/calibration_store.h"
#include "host/cli/failure.h"
#include "tests/dataset/scratch.h"
#include "tests/host/calibrate/wall_files.h"
#include "tests/host/calibrate/wall_simulator.h"

namespace stof::host {
namespace {

using test::put_wall;
using test::record;
using test::SimulatedCamera;

class CalibPmd : public test::Scratch {
 protected:
  CalibPmd() {
    camera_.offset_m = 0.2;
    camera_.wiggling.sine[3] = 0.03;
    camera_.pattern_m = 0.004;
    options_.folder = folder() / "walls";
    options_.out = folder() / "rig.cal";
    options_.json = true;
    std::filesystem::create_directories(options_.folder);
  }

  void put_walls(const std::vector<double>& distances, const std::string& more = "") {
    for (const double z : distances) {
      put_wall(options_.folder, record(camera_, z, 4, 5), more);
    }
  }

  void expect_refused(const std::string& fact) const {
    try {
      calib_pmd(options_);
      FAIL() << "not refused: " << fact;
    } catch (const Failure& failure) {
      const std::string line = failure.what();
      EXPECT_EQ(failure.code(), Exit::kBadInput);
      EXPECT_NE(line.find(fact), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
    EXPECT_FALSE(std::filesystem::exists(options_.out));
  }

  SimulatedCamera camera_;
  CalibPmdOptions options_;
};

TEST_F(CalibPmd, WritesAFileThatKeepsTheRigOfAnother) {
  put_walls({0.7, 1.1, 1.5, 2, 2.5, 3, 3.5});
  dsp::Calibration rig;
  rig.stereo.left = {.width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240};
  rig.stereo.baseline_m = 0.16;
  rig.pmd = record(camera_, 1, 1, 1).recording.calibration.pmd;
  rig.pmd_to_stereo.translation_m = {0.01, 0.3, -0.2};
  options_.start = folder() / "start.cal";
  ASSERT_TRUE(write_calibration(options_.start, rig));
  options_.plots = folder() / "plots";
  calib_pmd(options_);
  const dataset::Loaded<StoredCalibration> stored = read_calibration(options_.out);
  ASSERT_TRUE(stored) << stored.error().message;
  const dsp::Calibration& found = stored->calibration;
  EXPECT_STREQ(dsp::problem(found), "");
  EXPECT_EQ(found.stereo.baseline_m, 0.16);
  EXPECT_EQ(found.stereo.left.fx, 600);
  EXPECT_EQ(found.pmd_to_stereo.translation_m, rig.pmd_to_stereo.translation_m);
  EXPECT_EQ(found.pmd.fixed_pattern.size(), 32U * 24U);
  EXPECT_NE(found.pmd.frequency.wiggling, dsp::WigglingTable{});
  EXPECT_NEAR(found.pmd.electrons_per_lsb, camera_.electrons_per_lsb,
              0.2 * camera_.electrons_per_lsb);
  const std::string page =
      dataset::read_whole(options_.plots / "calibration.html", 10'000'000).value_or("");
  for (const char* name :
       {"What the line leaves", "Sigma of one reading", "Wiggling", "Fixed pattern"}) {
    EXPECT_NE(page.find(name), std::string::npos) << name;
  }
}

TEST_F(CalibPmd, TakesTheRigOfTheRecordings) {
  put_walls({0.7, 1.1, 1.5, 2, 2.5},
            R"(, "R": [1,0,0,0,1,0,0,0,1], "T": [0,0.3,0], "stereo": {"width": 640, "height": 480,
               "f_px": 700, "cx": 320, "cy": 240, "baseline_m": 0.12, "doff_px": 0})");
  calib_pmd(options_);
  const dataset::Loaded<StoredCalibration> stored = read_calibration(options_.out);
  ASSERT_TRUE(stored) << stored.error().message;
  EXPECT_EQ(stored->calibration.stereo.baseline_m, 0.12);
  EXPECT_EQ(stored->calibration.pmd_to_stereo.translation_m[1], 0.3);
}

TEST_F(CalibPmd, WritesNoFileOfAModelThatDoesNotExplainTheWallsUnlessForced) {
  put_walls({0.7, 1.1, 1.5, 2, 2.5, 3});
  WallRecording mistyped = record(camera_, 1.3, 4, 5);
  mistyped.z_m = 1.8;
  put_wall(options_.folder, mistyped);
  options_.plots = folder() / "plots";
  expect_refused("walls: the model does not explain these walls, no file is written");
  const auto page = [this] {
    return dataset::read_whole(options_.plots / "calibration.html", 10'000'000).value_or("");
  };
  EXPECT_EQ(page().find("frames that were not fitted to"), std::string::npos);
  EXPECT_NE(page().find("in all frames"), std::string::npos);
  options_.frames = "even";
  options_.force = true;
  calib_pmd(options_);
  EXPECT_TRUE(std::filesystem::exists(options_.out));
  EXPECT_NE(page().find("frames that were not fitted to"), std::string::npos);
}

// Of a wall that is typed wrong by a few centimetres the wiggling explains most.
TEST_F(CalibPmd, NamesAWallWhoseDistanceIsMistyped) {
  const std::vector<double> distances{1, 1.4, 1.8, 2.2, 2.6, 3};
  put_walls(distances);
  options_.frames = "even";
  calib_pmd(options_);
  ASSERT_TRUE(std::filesystem::exists(options_.out));
  for (const double wrong : {0.1, -0.1}) {
    std::filesystem::remove(options_.out);
    put_walls(distances);
    WallRecording mistyped = record(camera_, 1.8, 4, 5);
    mistyped.z_m = 1.8 + wrong;
    put_wall(options_.folder, mistyped);
    expect_refused(wrong > 0
                       ? "no file is written: z1800 is said to be at 1.900 m, the other walls put "
                         "it at 1.80"
                       : "no file is written: z1800 is said to be at 1.700 m, the other walls put "
                         "it at 1.");
    options_.force = true;
    calib_pmd(options_);
    EXPECT_TRUE(std::filesystem::exists(options_.out));
    options_.force = false;
  }
}

TEST_F(CalibPmd, SaysOneDirectionOfThePhase) {
  put_walls({1.5, 2, 2.5, 3});
  options_.json = false;
  ::testing::internal::CaptureStdout();
  calib_pmd(options_);
  const std::string text = ::testing::internal::GetCapturedStdout();
  EXPECT_NE(text.find("of this camera rises with distance"), std::string::npos) << text;
  EXPECT_EQ(text.find("fall"), std::string::npos) << text;
}

TEST_F(CalibPmd, RefusesTooFewDistances) {
  put_walls({1, 2});
  expect_refused("2 distance(s)");
}

TEST_F(CalibPmd, RefusesAFolderWithoutWalls) {
  expect_refused("holds no recording of a wall");
  options_.folder = folder() / "nowhere";
  expect_refused("not a folder");
}

TEST_F(CalibPmd, RefusesMixedCameras) {
  put_walls({1, 2, 3});
  camera_.f_mod_hz = 25'000'000;
  put_walls({4});
  expect_refused("modulation frequencies differ");
}

TEST_F(CalibPmd, RefusesWallsWithoutAUsablePixel) {
  camera_.white_lsb = 1e6;
  put_walls({1, 2, 3});
  expect_refused("saturated");
}

TEST_F(CalibPmd, RefusesWhatCannotBeRead) {
  put_walls({1, 2, 3});
  std::ofstream(options_.folder / "z2000.json") << "{ not json";
  expect_refused("z2000.json: is not a JSON object");
  put_walls({2}, ", \"int_scale\": -1");
  expect_refused("int_scale");
  put_walls({2});
  std::filesystem::resize_file(options_.folder / "z3000_raw.pgm", 100);
  expect_refused("z3000_raw.pgm");
  put_walls({3});
  options_.start = options_.folder / "z3000.json";
  expect_refused("not a calibration file");
}

TEST_F(CalibPmd, RefusesTheCalibrationOfAnotherCamera) {
  put_walls({1, 2, 3});
  dsp::Calibration rig;
  rig.pmd = record(camera_, 1, 1, 1).recording.calibration.pmd;
  rig.pmd.lens.width = 64;
  options_.start = folder() / "start.cal";
  ASSERT_TRUE(write_calibration(options_.start, rig));
  expect_refused("its PMD camera is 64x24");
  rig.pmd.lens.width = 32;
  rig.pmd.frequency.modulation.value = 15'000'000;
  ASSERT_TRUE(write_calibration(options_.start, rig));
  expect_refused("the recording's modulation frequency is 30 MHz, the calibration's 15 MHz");
  rig.pmd.frequency.modulation.value = camera_.f_mod_hz;
  rig.pmd.integration_us = 500;
  ASSERT_TRUE(write_calibration(options_.start, rig));
  put_walls({1, 2, 3}, ", \"integration_us\": 1000");
  expect_refused("the recording's integration time is 1000 us, the calibration's 500 us");
}

TEST_F(CalibPmd, RefusesNumbersThatCannotBeComputedWithWhereTheyStand) {
  put_walls({1, 2, 3});
  const dsp::PmdSensor good = record(camera_, 1, 1, 1).recording.calibration.pmd;
  options_.start = folder() / "start.cal";
  dsp::Calibration rig{.stereo = {}, .pmd = good, .pmd_to_stereo = {}};
  rig.pmd.dark_lsb = std::nan("");
  ASSERT_TRUE(write_calibration(options_.start, rig));
  expect_refused("start.cal: the dark level of a PMD sample");
  rig.pmd = good;
  rig.pmd.scale = 0;
  ASSERT_TRUE(write_calibration(options_.start, rig));
  expect_refused("start.cal: the straight line of PMD distances has a scale");
  rig.pmd = good;
  rig.stereo.left = {.width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240};
  rig.stereo.baseline_m = std::nan("");
  ASSERT_TRUE(write_calibration(options_.start, rig));
  expect_refused("start.cal: the baseline");
  options_.start.clear();
  options_.lens = {std::nan(""), 40, 16, 12};
  expect_refused("--lens: the PMD lens has");
  options_.lens.clear();
  options_.emitters = {0.1, 0, 5};
  expect_refused("--emitters: a light of the PMD camera is more than 2 m from its lens");
}

TEST_F(CalibPmd, RefusesAFolderForPlotsThatCannotBeOneBeforeItWrites) {
  put_walls({1, 2, 3});
  options_.plots = options_.folder / "z1000.json" / "plots";
  expect_refused("--plots");
}

TEST_F(CalibPmd, RefusesEmittersThatAreNoPlaces) {
  put_walls({1, 2, 3});
  options_.emitters = {0.1, 0, 0, 0.2};
  expect_refused("--emitters");
}

}  // namespace
}  // namespace stof::host
