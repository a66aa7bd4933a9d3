#include "host/cli/rig/calib_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "dataset/dataset.h"
#include "dataset/files/file.h"
#include "dsp/calib/pmd/ray_table.h"
#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/check/rig_check.h"
#include "host/calibrate/rig/planes/converging_model.h"
#include "host/cli/failure.h"
#include "tests/dataset/scratch.h"
#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/rendered_plane.h"

namespace stof::host {
namespace {

using test::blotches;
using test::chessboard;
using test::Gaussian;
using test::PlaneCamera;
using test::seen_from;
using test::true_pair;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kBaselineM = 0.12;

class CalibRig : public ::stof::test::Scratch {
 protected:
  void put_pair(const std::string& name, const dataset::Image<std::uint8_t>& left,
                const dataset::Image<std::uint8_t>& right) const {
    const std::filesystem::path dir = folder() / "views" / name;
    std::filesystem::create_directories(dir);
    EXPECT_TRUE(dataset::write_pgm8(dir / "left.pgm", left));
    EXPECT_TRUE(dataset::write_pgm8(dir / "right.pgm", right));
  }

  template <typename Work>
  static std::string refused(Exit code, const Work& work) {
    try {
      work();
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.code(), code) << failure.what();
      EXPECT_EQ(std::string(failure.what()).find('\n'), std::string::npos) << failure.what();
      return failure.what();
    }
    ADD_FAILURE() << "not refused";
    return {};
  }

  // What `stof calib check --json` prints of the views, and whether it is advised anything.
  nlohmann::json check_json(const char* calibration, bool fits) const {
    const CalibFolderOptions options{
        .folder = views(), .calibration = file(calibration), .json = true};
    testing::internal::CaptureStdout();
    std::string refusal;
    if (fits) {
      calib_check(options);
    } else {
      refusal = refused(Exit::kFailure, [&] { calib_check(options); });
    }
    const nlohmann::json said = nlohmann::json::parse(testing::internal::GetCapturedStdout());
    EXPECT_EQ(said.size(), 6U) << said;
    EXPECT_EQ(said.at("folder"), views().string());
    EXPECT_EQ(said.at("calibration"), file(calibration).string());
    EXPECT_EQ(said.at("advice").empty(), fits) << said;
    if (!fits) {
      EXPECT_EQ(refusal,
                file(calibration).string() + ": " + said.at("advice").at(0).get<std::string>());
    }
    return said;
  }

  std::filesystem::path views() const { return folder() / "views"; }
  std::filesystem::path file(const char* name) const { return folder() / name; }
};

TEST_F(CalibRig, PicturesOfABoardBecomeAPair) {
  const dsp::RawPair truth = true_pair();
  const PlaneCamera left(truth.left);
  const PlaneCamera right(truth.right);
  constexpr Board kBoard{.columns = 9, .rows = 6, .square_m = 0.03};
  Gaussian random(5);
  int n = 0;
  for (const PoseUnknowns& pose : test::waved_poses(truth, kBoard, 20, 11)) {
    const int smear = n == 7 ? 12 : 0;  // one was moved
    put_pair("view" + std::to_string(10 + n),
             left.picture(pose, chessboard(kBoard), 2, random, smear),
             right.picture(seen_from(pose_of(truth.left_to_right), pose), chessboard(kBoard), 2,
                           random, smear));
    ++n;
  }
  testing::internal::CaptureStdout();
  calib_stereo({.target = views(),
                .out = file("rig.cal"),
                .page = file("page.html"),
                .board = "9x6:0.03",
                .force = true});
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_NE(said.find("left out: view17: blurred"), std::string::npos) << said;
  const dataset::Loaded<StoredCalibration> found = read_calibration(file("rig.cal"));
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(found->calibration.stereo.raw);
  const dsp::RawPair& rig = *found->calibration.stereo.raw;
  EXPECT_NEAR(rig.left.fx / truth.left.fx, 1, 0.003) << said;
  EXPECT_NEAR(rig.right.fy / truth.right.fy, 1, 0.003) << said;
  const Matrix3 turn = rotation_of(pose_of(rig.left_to_right)) *
                       rotation_of(pose_of(truth.left_to_right)).transpose();
  EXPECT_LT(Eigen::AngleAxisd(turn).angle(), 0.15 * kDegree) << said;
  EXPECT_NEAR(found->calibration.stereo.baseline_m, 0.12, 0.0006) << said;
  const dataset::Loaded<std::string> page = dataset::read_whole(file("page.html"), 1U << 26);
  ASSERT_TRUE(page);
  EXPECT_NE(page->find("<svg"), std::string::npos);
  EXPECT_NE(page->find("view17"), std::string::npos);
}

TEST_F(CalibRig, AFolderWithoutABoardIsRefused) {
  put_pair("a", {640, 480, 90}, {640, 480, 90});
  testing::internal::CaptureStdout();
  EXPECT_NE(
      refused(Exit::kBadInput, [&] { calib_stereo({.target = views(), .out = file("rig.cal")}); })
          .find("no picture of 1 views shows the board 9x6:0.024: check --board"),
      std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file("rig.cal")));
  refused(Exit::kBadInput, [&] { calib_stereo({.out = file("rig.cal")}); });
  refused(Exit::kBadInput, [&] { calib_stereo({.target = folder(), .out = file("rig.cal")}); });
  refused(Exit::kBadInput,
          [&] { calib_stereo({.target = views(), .out = file("rig.cal"), .json = true}); });
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

dataset::Image<std::uint8_t> mirror_of(dataset::Image<std::uint8_t> picture) {
  for (int v = 0; v < picture.height; ++v) {
    std::ranges::reverse(picture.view().row(v));
  }
  return picture;
}

TEST_F(CalibRig, SaysWhichEyeDoesNotSeeTheBoard) {
  const dataset::Loaded<Board> board = board_named("charuco:9x6:0.04");
  ASSERT_TRUE(board);
  const PlaneCamera camera(
      {.width = 320, .height = 240, .fx = 305, .fy = 305, .cx = 160, .cy = 120});
  Gaussian random(3);
  const auto view = [&](int smear) {
    return camera.picture(test::board_at(*board, Vector3(0, 0, 0.5), Vector3(0.2, 0.2, 0)),
                          test::print_of(*board), 1, random, smear);
  };
  const dataset::Image<std::uint8_t> sharp = view(0);
  const dataset::Image<std::uint8_t> smeared = view(3);
  const dataset::Image<std::uint8_t> covered(320, 240, 3);
  const auto said = [&](const dataset::Image<std::uint8_t>& left,
                        const dataset::Image<std::uint8_t>& right) {
    put_pair("a", left, right);
    return refused(Exit::kBadInput, [&] {
      calib_stereo({.target = views(),
                    .out = file("rig.cal"),
                    .board = "charuco:9x6:0.04",
                    .most_blur_px = 0.7});
    });
  };
  const auto tells = [](const std::string& line, const char* what) {
    EXPECT_NE(line.find(what), std::string::npos) << line;
  };
  tells(said(covered, covered), "no picture of 1 views shows the board charuco:9x6:0.04");
  tells(said(sharp, covered),
        "the right camera sees the board in none of 1 views, the left one in 1: uncover it");
  tells(said(covered, sharp), "the left camera sees the board in none of 1 views");
  tells(said(mirror_of(sharp), mirror_of(sharp)), "both cameras show the board mirrored");
  tells(said(sharp, mirror_of(sharp)), "the right camera shows the board mirrored");
  tells(said(smeared, smeared), "no view of 1 counts (a: blurred");
  EXPECT_FALSE(std::filesystem::exists(file("rig.cal")));
}

// The chapter's rig, with axes that meet at 4 m.
TEST_F(CalibRig, WallsAtKnownDistancesBecomeAConvergingRig) {
  constexpr PlaneUnknowns kTruth{0.2, 0.025, -0.025, 0.0085, 0.0085};
  const dsp::Pinhole lens{
      .width = 640, .height = 480, .fx = 8500 / 5.6, .fy = 8500 / 5.6, .cx = 319.5, .cy = 239.5};
  const PlaneCamera camera(lens);
  const auto from_rig = [](double yaw, double x) {
    const Matrix3 back = Eigen::AngleAxisd(-yaw, Vector3::UnitY()).toRotationMatrix().transpose();
    return pose_of(back, Vector3(back * Vector3(-x, 0, 0)));
  };
  Gaussian random(8);
  for (const double z : {1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0}) {
    const PoseUnknowns wall{0, 0, 0, 0, 0, z};
    const std::string name = "wall" + std::to_string(std::lround(z * 100));
    put_pair(
        name, camera.picture(seen_from(from_rig(kTruth[2], 0), wall), blotches(3), 1, random),
        camera.picture(seen_from(from_rig(kTruth[1], kTruth[0]), wall), blotches(3), 1, random));
    EXPECT_TRUE(dataset::write_whole(views() / name / "meta.txt",
                                     "ndisp 256\nplane_z_m " + std::to_string(z) + "\n"));
  }
  testing::internal::CaptureStdout();
  calib_stereo({.planes = views(),
                .out = file("rig.cal"),
                .min_disparity = -20,
                .disparities = 160,
                .chapter = true,
                .threads = 2,
                .json = true});
  const nlohmann::json told = nlohmann::json::parse(testing::internal::GetCapturedStdout());
  const dataset::Loaded<StoredCalibration> found = read_calibration(file("rig.cal"));
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(found->calibration.stereo.converging);
  const dsp::Converging& rig = *found->calibration.stereo.converging;
  const PlaneUnknowns x{found->calibration.stereo.baseline_m, rig.alpha_rad, rig.beta_rad, rig.f1_m,
                        rig.f2_m};
  EXPECT_NEAR(triangulation_constant(x) / triangulation_constant(kTruth), 1, 0.005);
  EXPECT_NEAR(zero_disparity_m(x), 4, 0.02);
  EXPECT_LE(told.at("spread_mm"), 7.7) << "the chapter's";
  EXPECT_GT(told.at("held_out_mm"), 0);
  EXPECT_EQ(told.at("file"), file("rig.cal").string());
  EXPECT_EQ(told.at("folder"), views().string());
  EXPECT_EQ(told.at("baseline_m"), x[0]);
  EXPECT_EQ(told.at("alpha_rad"), x[1]);
  EXPECT_NEAR(told.at("axes_meet_m"), 4, 0.02);
  EXPECT_NEAR(told.at("constant_m2").get<double>(), triangulation_constant(x), 1e-9);
  EXPECT_EQ(told.at("covariance").size(), kPlaneUnknowns);
  EXPECT_NEAR(told.at("covariance").at(4).at(4).get<double>(),
              std::pow(told.at("sigma").at(4).get<double>(), 2), 1e-15);
  ASSERT_EQ(told.at("walls").size(), 7U);
  EXPECT_EQ(told.at("walls").at(0).at("name"), "wall160");
  EXPECT_EQ(told.at("walls").at(0).at("z_m"), 1.6);
  EXPECT_TRUE(told.at("walls").at(0).at("fitted"));
  EXPECT_GT(told.at("chapter").at("table2_rms_mm"), 0);
}

const PoseUnknowns kPmdPose{0.03, -0.05, 0.02, 0.09, -0.03, 0.02};

dsp::Calibration rig_with_pmd() {
  dsp::Calibration rig;
  rig.stereo.left = {.width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 319.5, .cy = 239.5};
  rig.stereo.baseline_m = kBaselineM;
  rig.pmd.lens = {.width = 64, .height = 16, .fx = 45.28, .fy = 45.28, .cx = 32.8, .cy = 10};
  rig.pmd_to_stereo = transform_of(kPmdPose);
  return rig;
}

// Samples of a plane: offset + amplitude cos(phase + 90 k degrees), with noise.
dataset::PmdRecording samples_of(const dsp::Calibration& rig, const PoseUnknowns& plane_to_left,
                                 int frames, Gaussian& random) {
  const dsp::Pinhole& lens = rig.pmd.lens;
  const Matrix3 back = rotation_of(kPmdPose).transpose();
  const Vector3 normal = back * rotation_of(plane_to_left).col(2);
  const Vector3 origin = back * (translation_of(plane_to_left) - translation_of(kPmdPose));
  dataset::PmdRecording recording;
  recording.calibration = rig;
  recording.has_rig = true;
  for (int n = 0; n < frames; ++n) {
    dataset::Image<std::uint16_t> frame(lens.width, 4 * lens.height);
    for (int v = 0; v < lens.height; ++v) {
      for (int u = 0; u < lens.width; ++u) {
        const std::array<double, 3> r = dsp::unit_ray(lens, u, v);
        const double d = normal.dot(origin) / normal.dot(Vector3(r[0], r[1], r[2]));
        const double phase = 2 * std::numbers::pi * d / (299792458.0 / (2 * 20e6));
        for (int k = 0; k < 4; ++k) {
          const double value =
              1600 + 900 * std::cos(phase + k * std::numbers::pi / 2) + random.next(6);
          frame.view().at(u, v + k * lens.height) = static_cast<std::uint16_t>(std::lround(value));
        }
      }
    }
    recording.frames.push_back(std::move(frame));
  }
  return recording;
}

class CalibRigWalls : public CalibRig {
 protected:
  static std::vector<std::array<double, 3>> tilted() {
    return {{0, 0, 1.5},    {0.5, 0, 1.4},   {-0.5, 0, 1.6},
            {0, 0.45, 1.5}, {0, -0.45, 1.3}, {0.35, 0.35, 1.7}};
  }
  // Walls at these tilts (sideways, upwards, distance), seen by both. rows: the right camera looks
  // that many px too high.
  void put_walls(const std::vector<std::array<double, 3>>& walls, double rows = 0) {
    const dsp::Calibration rig = rig_with_pmd();
    const PlaneCamera left(rig.stereo.left);
    dsp::Pinhole lens = rig.stereo.left;
    lens.cy += rows;
    const PlaneCamera right(lens);
    const PoseUnknowns to_right{0, 0, 0, -kBaselineM, 0, 0};
    Gaussian random(21);
    int n = 0;
    for (const auto& [sideways, upwards, distance] : walls) {
      const Vector3 normal = Vector3(std::tan(sideways), std::tan(upwards), 1).normalized();
      const Matrix3 turn =
          Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), normal).toRotationMatrix();
      const PoseUnknowns wall = pose_of(turn, Vector3(0, 0, distance));
      const std::string name = "wall" + std::to_string(n++);
      put_pair(name, left.picture(wall, blotches(5), 1, random),
               right.picture(seen_from(to_right, wall), blotches(5), 1, random));
      EXPECT_TRUE(dataset::write_pmd(views() / name / "pmd", samples_of(rig, wall, 16, random)));
    }
  }
};

TEST_F(CalibRigWalls, TiltedWallsTellWhereThePmdCameraIs) {
  put_walls(tilted());
  dsp::Calibration start = rig_with_pmd();
  start.pmd_to_stereo = {};
  ASSERT_TRUE(write_calibration(file("start.cal"), start));
  testing::internal::CaptureStdout();
  calib_extrinsics(
      {.folder = views(), .calibration = file("start.cal"), .out = file("rig.cal"), .json = true});
  const std::string said = testing::internal::GetCapturedStdout();
  const nlohmann::json told = nlohmann::json::parse(said);
  EXPECT_EQ(told.at("file"), file("rig.cal").string());
  EXPECT_EQ(told.at("walls").size(), 6U);
  EXPECT_TRUE(told.at("missing").empty());
  EXPECT_EQ(told.at("covariance").size(), 6U);
  const dataset::Loaded<StoredCalibration> found = read_calibration(file("rig.cal"));
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(told.at("translation_m"), found->calibration.pmd_to_stereo.translation_m);
  const PoseUnknowns pose = pose_of(found->calibration.pmd_to_stereo);
  const Matrix3 turn = rotation_of(pose) * rotation_of(kPmdPose).transpose();
  const double shift = (translation_of(pose) - translation_of(kPmdPose)).norm();
  std::printf("figure: 64x16 by walls: %.3f degrees, %.1f mm\n",
              Eigen::AngleAxisd(turn).angle() / kDegree, shift * 1000);
  EXPECT_LT(Eigen::AngleAxisd(turn).angle(), 0.3 * kDegree) << said;
  EXPECT_LT(shift, 0.015) << said;
  // The new file fits the rig, the old one does not.
  testing::internal::CaptureStdout();
  calib_check({.folder = views(), .calibration = file("rig.cal")});
  EXPECT_NE(testing::internal::GetCapturedStdout().find("nothing to do"), std::string::npos);
  EXPECT_NE(refused(Exit::kFailure,
                    [&] { calib_check({.folder = views(), .calibration = file("start.cal")}); })
                .find("the sensors disagree"),
            std::string::npos);
  const nlohmann::json fits = check_json("rig.cal", true);
  EXPECT_LT(std::abs(fits.at("depths").at("median_mm").get<double>()), kLargestDepthMm);
  EXPECT_GT(fits.at("depths").at("spread_mm"), 0);
  EXPECT_GT(fits.at("depths").at("points"), 100);
}

// Here a PMD camera that counts a degree off at its borders, as one does that was calibrated before
// walls it did not face.
TEST_F(CalibRigWalls, WallsThatTheSensorsSeeApartAreRefused) {
  put_walls(tilted());
  dsp::Calibration start = rig_with_pmd();
  start.pmd.emitter_count = 1;
  start.pmd.emitters[0] = {-0.2, -0.15, 0};
  ASSERT_TRUE(write_calibration(file("start.cal"), start));
  CalibFolderOptions options{
      .folder = views(), .calibration = file("start.cal"), .out = file("rig.cal")};
  testing::internal::CaptureStdout();
  EXPECT_NE(refused(Exit::kBadInput, [&] { calib_extrinsics(options); })
                .find("the sensors see these walls"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file("rig.cal")));
  options.force = true;
  calib_extrinsics(options);
  EXPECT_TRUE(std::filesystem::exists(file("rig.cal")));
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_NE(said.find("mm apart"), std::string::npos) << said;
}

TEST_F(CalibRigWalls, WallsThatAllStandAlikeAreRefusedWithTheTiltThatIsMissing) {
  put_walls({{0, 0, 1.5}, {0.02, 0, 1.4}, {-0.02, 0, 1.6}, {0, 0.02, 1.5}, {0, -0.02, 1.3}});
  ASSERT_TRUE(write_calibration(file("start.cal"), rig_with_pmd()));
  EXPECT_NE(
      refused(Exit::kBadInput,
              [&] {
                calib_extrinsics(
                    {.folder = views(), .calibration = file("start.cal"), .out = file("rig.cal")});
              })
          .find("sideways"),
      std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file("rig.cal")));
}

TEST_F(CalibRigWalls, CheckSaysThatRowsDoNotCorrespond) {
  put_walls({{0.3, 0.1, 1.5}}, 2);
  dsp::Calibration rig = rig_with_pmd();
  rig.pmd = {};
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
  EXPECT_NE(refused(Exit::kFailure,
                    [&] { calib_check({.folder = views(), .calibration = file("rig.cal")}); })
                .find("rows do not correspond"),
            std::string::npos);
  const nlohmann::json said = check_json("rig.cal", false);
  EXPECT_NEAR(std::abs(said.at("rows").at("median_px").get<double>()), 2, 0.3) << said;
  EXPECT_TRUE(said.at("depths").is_null()) << said;
}

TEST_F(CalibRig, CheckRectifiesARawPair) {
  const dsp::RawPair truth = true_pair();
  const PoseUnknowns wall{0, 0.2, 0, 0, 0, 1.4};
  Gaussian random(6);
  put_pair("wall", PlaneCamera(truth.left).picture(wall, blotches(5), 1, random),
           PlaneCamera(truth.right)
               .picture(seen_from(pose_of(truth.left_to_right), wall), blotches(5), 1, random));
  dsp::Calibration rig;
  rig.stereo.raw = truth;
  ASSERT_STREQ(dsp::complete(rig.stereo), "");
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
  testing::internal::CaptureStdout();
  calib_check({.folder = views(), .calibration = file("rig.cal")});
  EXPECT_NE(testing::internal::GetCapturedStdout().find("nothing to do"), std::string::npos);
  const nlohmann::json said = check_json("rig.cal", true);
  const nlohmann::json& rows = said.at("rows");
  EXPECT_GT(rows.at("points"), 20);
  for (const char* const name : {"median_px", "rms_px", "slope_px"}) {
    EXPECT_LT(std::abs(rows.at(name).get<double>()), kLargestRowPx) << name;
  }
  EXPECT_TRUE(said.at("depths").is_null()) << said;
}

TEST_F(CalibRig, CheckDoesNotSayThatARigFitsWhoseRowsItCannotJudge) {
  const dsp::RawPair truth = true_pair();
  Gaussian random(6);
  const dataset::Image<std::uint8_t> left =
      PlaneCamera(truth.left).picture({0, 0.2, 0, 0, 0, 1.4}, blotches(5), 1, random);
  put_pair("wall", left, {left.width, left.height, 3});  // the right camera is covered
  dsp::Calibration rig;
  rig.stereo.raw = truth;
  ASSERT_STREQ(dsp::complete(rig.stereo), "");
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
  EXPECT_NE(refused(Exit::kBadInput,
                    [&] { calib_check({.folder = views(), .calibration = file("rig.cal")}); })
                .find("shows too little to judge a rig by"),
            std::string::npos);
  // Depths alone are no reason to be content.
  const std::vector<std::string> lines = advice(
      {.rows = std::nullopt, .depths = DepthCheck{.points = 100, .median_mm = 1, .spread_mm = 5}});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(lines[0].starts_with("rows cannot be judged")) << lines[0];
}

TEST_F(CalibRig, CheckPrintsNoJsonOfWhatItCannotRead) {
  dsp::Calibration rig;
  rig.stereo.raw = true_pair();
  ASSERT_STREQ(dsp::complete(rig.stereo), "");
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
  testing::internal::CaptureStdout();
  for (const char* const calibration : {"rig.cal", "none.cal"}) {  // neither folder nor file
    refused(Exit::kBadInput, [&] {
      calib_check({.folder = views(), .calibration = file(calibration), .json = true});
    });
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace stof::host
