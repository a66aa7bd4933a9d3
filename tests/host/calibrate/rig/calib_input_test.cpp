// Wrong input of `stof calib`: one line, the documented code, and nothing is left. And what it
// writes that it reads again.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "dataset/dataset.h"
#include "dataset/files/file.h"
#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/check/rig_check.h"
#include "host/cli/failure.h"
#include "host/cli/rig/calib_rig.h"
#include "host/cli/rig/live_views.h"
#include "host/text/printed.h"
#include "tests/dataset/scratch.h"
#include "tests/host/calibrate/rig/board_views.h"

namespace stof::host {
namespace {

class CalibRigInput : public ::stof::test::Scratch {
 protected:
  void put_pair(const std::string& name, const dataset::Image<std::uint8_t>& left,
                const dataset::Image<std::uint8_t>& right) const {
    const std::filesystem::path dir = views() / name;
    std::filesystem::create_directories(dir);
    EXPECT_TRUE(dataset::write_pgm8(dir / "left.pgm", left));
    EXPECT_TRUE(dataset::write_pgm8(dir / "right.pgm", right));
  }

  static void put_true_pair(const std::filesystem::path& to) {
    dsp::Calibration rig;
    rig.stereo.raw = test::true_pair();
    ASSERT_STREQ(dsp::complete(rig.stereo), "");
    ASSERT_TRUE(write_calibration(to, rig));
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

  static dsp::Calibration rig_with_pmd() {
    dsp::Calibration rig;
    rig.stereo.left = {.width = 64, .height = 48, .fx = 60, .fy = 60, .cx = 31.5, .cy = 23.5};
    rig.stereo.baseline_m = 0.12;
    rig.pmd.lens = {.width = 64, .height = 16, .fx = 45.28, .fy = 45.28, .cx = 32.8, .cy = 10};
    return rig;
  }

  std::filesystem::path views() const { return folder() / "views"; }
  std::filesystem::path file(const char* name) const { return folder() / name; }
};

TEST_F(CalibRigInput, AViewWithOnePictureAloneIsNamed) {
  ASSERT_TRUE(write_calibration(file("start.cal"), rig_with_pmd()));
  for (const char* const eye : {"left.pgm", "right.pgm"}) {
    put_pair("a", {64, 48, 90}, {64, 48, 90});
    put_pair("b", {64, 48, 90}, {64, 48, 90});
    std::filesystem::remove(views() / "b" / eye);
    const std::string line = refused(Exit::kBadInput, [&] {
      calib_extrinsics(
          {.folder = views(), .calibration = file("start.cal"), .out = file("rig.cal")});
    });
    EXPECT_NE(line.find((views() / "b").string() + ": has no " + eye), std::string::npos) << line;
  }
}

// A sensor at an address where nobody answers, and what it leaves: nothing.
TEST_F(CalibRigInput, NothingIsLeftWhereNoSensorAnswers) {
  ASSERT_TRUE(write_calibration(file("start.cal"), rig_with_pmd()));
  CalibLiveOptions live;
  live.sensor = "127.0.0.1:9";
  live.timeout_s = 0.2;
  CalibFolderOptions folder{
      .live = live, .calibration = file("start.cal"), .out = file("rig.cal"), .json = true};
  CalibStereoOptions stereo{.live = live, .out = file("rig.cal"), .json = true};
  CalibStereoOptions planes{.live = live,
                            .planes = file("planes"),
                            .out = file("rig.cal"),
                            .distances = {1.6},
                            .json = true};
  testing::internal::CaptureStdout();
  refused(Exit::kFailure, [&] { calib_extrinsics(folder); });
  refused(Exit::kFailure, [&] { calib_check(folder); });
  refused(Exit::kFailure, [&] { calib_stereo(stereo); });
  refused(Exit::kFailure, [&] { calib_stereo(planes); });
  // What is wrong with the command line is told before a sensor is asked.
  folder.board = "charuco:9x6:0.04";
  EXPECT_NE(refused(Exit::kBadInput, [&] { calib_extrinsics(folder); }).find("has markers"),
            std::string::npos);
  stereo.page = file("start.cal") / "page.html";
  EXPECT_TRUE(refused(Exit::kBadInput, [&] { calib_stereo(stereo); }).starts_with("--html "));
  const std::string told = testing::internal::GetCapturedStdout();
  EXPECT_TRUE(told.starts_with("{\"state\":\"subscribing\"")) << told;
  EXPECT_EQ(std::ranges::count(told, '\n'), 1) << told;
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(this->folder())) {
    left.push_back(entry.path().filename());
  }
  EXPECT_EQ(left, std::vector<std::string>{"start.cal"});
}

TEST_F(CalibRigInput, SaysHowManyViewsHaveOnePictureAlone) {
  for (const char* const view : {"c", "a", "b"}) {
    put_pair(view, {64, 48, 90}, {64, 48, 90});
    std::filesystem::remove(views() / view / "right.pgm");
  }
  const std::string line =
      refused(Exit::kBadInput, [&] { calib_stereo({.target = views(), .out = file("rig.cal")}); });
  EXPECT_NE(line.find((views() / "a").string() + ": has no right.pgm, as 2 more miss one of both"),
            std::string::npos)
      << line;
}

TEST_F(CalibRigInput, WhatIsNoFolderIsToldAsWhatItIs) {
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig_with_pmd()));
  for (const auto& [name, what] :
       {std::pair("nothere", ": does not exist"), std::pair("rig.cal", ": is no folder")}) {
    const std::string line = refused(
        Exit::kBadInput, [&] { calib_stereo({.target = file(name), .out = file("made.cal")}); });
    EXPECT_NE(line.find(file(name).string() + what), std::string::npos) << line;
  }
}

// What is read, and what is no calibration, outlasts a mistyped --out.
TEST_F(CalibRigInput, NothingButACalibrationIsWrittenOver) {
  put_true_pair(file("rig.cal"));
  testing::internal::CaptureStdout();
  calib_export({.format = "opencv", .files = {}, .out = file("cv.yml"), .start = file("rig.cal")});
  calib_export({.format = "opencv", .files = {}, .out = file("other"), .start = file("rig.cal")});
  const dataset::Loaded<std::string> before = dataset::read_whole(file("cv.yml"), 1U << 20);
  ASSERT_TRUE(before);
  const auto import_to = [&](const std::filesystem::path& out) {
    calib_import({.format = "opencv", .files = {file("cv.yml")}, .out = out});
  };
  std::filesystem::create_symlink(file("cv.yml"), file("link"));
  for (const char* const name : {"cv.yml", "link"}) {
    EXPECT_NE(refused(Exit::kBadInput, [&] { import_to(file(name)); }).find("is what is read"),
              std::string::npos);
  }
  EXPECT_NE(refused(Exit::kBadInput, [&] { import_to(file("other")); })
                .find("is there and is no calibration"),
            std::string::npos);
  EXPECT_NE(refused(Exit::kBadInput,
                    [&] {
                      calib_export({.format = "opencv",
                                    .files = {},
                                    .out = file("rig.cal"),
                                    .start = file("rig.cal")});
                    })
                .find("is what is read"),
            std::string::npos);
  const dataset::Loaded<std::string> after = dataset::read_whole(file("cv.yml"), 1U << 20);
  ASSERT_TRUE(after);
  EXPECT_EQ(*before, *after);
  EXPECT_TRUE(read_calibration(file("rig.cal")));
  import_to(file("rig.cal"));  // one calibration over another
  import_to(file("new.cal"));
  testing::internal::GetCapturedStdout();
}

TEST_F(CalibRigInput, AnOutThatIsNoFileIsToldAsWhatItIs) {
  put_true_pair(file("rig.cal"));
  testing::internal::CaptureStdout();
  calib_export({.format = "opencv", .files = {}, .out = file("cv.yml"), .start = file("rig.cal")});
  testing::internal::GetCapturedStdout();
  const auto import_to = [&](Exit code, const std::filesystem::path& out) {
    return refused(
        code, [&] { calib_import({.format = "opencv", .files = {file("cv.yml")}, .out = out}); });
  };
  EXPECT_NE(import_to(Exit::kBadInput, folder()).find("is a folder: give a file"),
            std::string::npos);
  EXPECT_NE(import_to(Exit::kBadInput, "").find("--out: names no file"), std::string::npos);
  EXPECT_NE(import_to(Exit::kBadInput, file("rig.cal") / "x").find("is not a folder"),
            std::string::npos);
  // As everywhere: a full disk is 1.
  EXPECT_NE(import_to(Exit::kFailure, "/dev/full").find("/dev/full: cannot be written"),
            std::string::npos);
}

TEST_F(CalibRigInput, WhatIsExportedIsImportedAgain) {
  dsp::Calibration rig;
  rig.stereo.raw = test::true_pair();
  ASSERT_STREQ(dsp::complete(rig.stereo), "");
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
  const auto printed_by = [](const auto& work) {
    testing::internal::CaptureStdout();
    work();
    return nlohmann::json::parse(testing::internal::GetCapturedStdout());
  };
  for (const char* const format : {"kalibr", "opencv", "ros"}) {
    const nlohmann::json written = printed_by([&] {
      calib_export({.format = format,
                    .files = {},
                    .out = file("out"),
                    .start = file("rig.cal"),
                    .json = true});
    });
    for (const nlohmann::json& name : written.at("files")) {
      EXPECT_TRUE(std::filesystem::is_regular_file(name.get<std::string>())) << written;
    }
    std::vector<std::filesystem::path> files{file("out")};
    if (std::string_view(format) == "ros") {
      files = {file("out") / "left.yaml", file("out") / "right.yaml"};
    }
    EXPECT_EQ(written.at("files").size(), files.size());
    const nlohmann::json told = printed_by([&] {
      calib_import({.format = format, .files = files, .out = file("again.cal"), .json = true});
    });
    EXPECT_NEAR(told.at("baseline_m").get<double>(), rig.stereo.baseline_m, 1e-9) << told;
    const dataset::Loaded<StoredCalibration> again = read_calibration(file("again.cal"));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_NEAR(again->calibration.stereo.left.fx, rig.stereo.left.fx, 1e-9) << format;
    EXPECT_NEAR(again->calibration.stereo.baseline_m, rig.stereo.baseline_m, 1e-9) << format;
    std::filesystem::remove_all(file("out"));
  }
  refused(Exit::kBadInput, [&] {
    calib_import({.format = "ros", .files = {file("rig.cal")}, .out = file("again.cal")});
  });
  refused(Exit::kBadInput, [&] {
    calib_import({.format = "kalibr", .files = {file("rig.cal")}, .out = file("again.cal")});
  });
}

TEST_F(CalibRigInput, TheSheetOfABoardIsToldAsJson) {
  for (const char* const name : {"board.pdf", "board.pgm"}) {
    testing::internal::CaptureStdout();
    calib_target({.board = "9x6:0.024", .paper = "a4", .out = file(name), .json = true});
    const nlohmann::json told = nlohmann::json::parse(testing::internal::GetCapturedStdout());
    EXPECT_EQ(told.at("file"), file(name).string());
    EXPECT_EQ(told.at("board"), "9x6:0.024");
    EXPECT_TRUE(std::filesystem::exists(file(name)));
  }
}

TEST(RigCheck, SaysFromWhichTurnOnThePmdCameraWouldShow) {
  RigCheck check{.rows = RowCheck{.points = 50},
                 .depths = DepthCheck{.points = 100,
                                      .median_mm = 3,
                                      .spread_mm = 12,
                                      .turn_shows_deg = {1.5, 4, DepthCheck::kNever}}};
  ASSERT_EQ(doubts(check).size(), 1U);
  EXPECT_EQ(doubts(check)[0].substr(0, 131),
            "a PMD camera that is turned shows here from 1.5 degrees up or down, 4 degrees "
            "sideways and more than 10 degrees about its axis on (");
  check.depths.reset();
  EXPECT_EQ(doubts(check).size(), 1U);
}

// Both look at a plane that is tilted about x: what is turned shows where it is said to, and not
// much before.
TEST_F(CalibRigInput, ATurnShowsFromWhereItsVerdictChanges) {
  dsp::Calibration rig = rig_with_pmd();
  rig.stereo.left.fx = 8000;  // looks of the same place are near each other
  rig.pmd_to_stereo = transform_of(PoseUnknowns{});
  BothLooks both;
  for (int v = -100; v <= 100; ++v) {
    for (const double x : {-0.2, 0.0, 0.2}) {
      const Vector3 ray(x, v * 0.002, 1);
      const double q = 0.5 + 0.9 * ray.y();  // of 1 / z: tilted about x alone
      both.stereo.push_back({.ray = ray, .q = q});
      both.pmd.push_back({.ray = ray, .q = q});
    }
  }
  const std::optional<DepthCheck> check = check_depths({both}, rig);
  ASSERT_TRUE(check);
  EXPECT_NEAR(check->median_mm, 0, 0.1);
  const double pitch = check->turn_shows_deg[0];
  EXPECT_LE(pitch, 1);
  EXPECT_GT(check->turn_shows_deg[2], pitch);
  const auto turned = [&](double degrees) {
    dsp::Calibration off = rig;
    PoseUnknowns pose{};
    pose[0] = degrees / kDegrees;
    off.pmd_to_stereo = transform_of(pose);
    return std::abs(check_depths({both}, off)->median_mm);
  };
  EXPECT_GT(turned(pitch), kLargestDepthMm);
  EXPECT_LT(turned(pitch / 3), kLargestDepthMm);
  // Distances that are off already hide as much of it.
  for (PlaneLook& look : both.pmd) {
    look.q += 0.007;
  }
  EXPECT_GT(check_depths({both}, rig)->turn_shows_deg[0], pitch);
}

TEST_F(CalibRigInput, AFileThatIsNoneOfTheKindIsNotLostToASheetOrAnExport) {
  put_true_pair(file("rig.cal"));
  std::filesystem::create_directories(file("ros"));
  for (const char* const name : {"diary.pdf", "diary.pgm", "diary.yaml", "ros/right.yaml"}) {
    std::ofstream(file(name)) << "my diary\n";
  }
  const auto target = [&](const char* out) {
    calib_target({.board = "9x6:0.024", .paper = "a4", .out = file(out), .json = true});
  };
  const auto to = [&](const char* format, const char* out) {
    calib_export({.format = format, .out = file(out), .start = file("rig.cal"), .json = true});
  };
  const auto keeps = [&](const char* kind, auto&& work) {
    const std::string line = refused(Exit::kBadInput, work);
    EXPECT_NE(line.find(std::string("is there and is no ") + kind), std::string::npos) << line;
  };
  keeps("PDF", [&] { target("diary.pdf"); });
  keeps("PGM", [&] { target("diary.pgm"); });
  keeps("file of opencv", [&] { to("opencv", "diary.yaml"); });
  keeps("file of kalibr", [&] { to("kalibr", "diary.yaml"); });
  keeps("file of ros", [&] { to("ros", "ros"); });
  EXPECT_FALSE(std::filesystem::exists(file("ros/left.yaml")));
  for (const char* const name : {"diary.pdf", "diary.pgm", "diary.yaml", "ros/right.yaml"}) {
    EXPECT_EQ(dataset::read_whole(file(name), 100).value_or(""), "my diary\n") << name;
  }
  // An older one of the kind is what it replaces.
  std::filesystem::remove_all(file("ros"));
  testing::internal::CaptureStdout();
  for (int again = 0; again < 2; ++again) {
    target("board.pdf");
    target("board.pgm");
    to("opencv", "opencv.yaml");
    to("kalibr", "kalibr.yaml");
    to("ros", "ros");
  }
  testing::internal::GetCapturedStdout();
  EXPECT_NE(
      refused(Exit::kBadInput, [&] { target("nodir/x.pdf"); }).find("its folder is not there"),
      std::string::npos);
  EXPECT_NE(refused(Exit::kBadInput, [&] { target("x.png"); }).find("neither .pdf nor .pgm"),
            std::string::npos);
}

TEST_F(CalibRigInput, AHalfViewInTheFolderOfALiveRunIsNamed) {
  put_pair("view_001", {64, 48, 90}, {64, 48, 90});
  put_pair("view_002", {64, 48, 90}, {64, 48, 90});
  std::filesystem::remove(views() / "view_002" / "right.pgm");
  const std::string line = refused(Exit::kBadInput, [&] { KeptViews(views(), "view"); });
  EXPECT_NE(line.find("view_002: has no right.pgm: add it, or remove the folder"),
            std::string::npos)
      << line;
  std::filesystem::remove_all(views() / "view_002");
  EXPECT_EQ(KeptViews(views(), "view").count(), 1U);
}

TEST_F(CalibRigInput, AViewThatCannotBeWrittenWholeLeavesNothingAndIsNoBadInput) {
  put_pair("view_001", {64, 48, 90}, {64, 48, 90});
  const KeptViews kept(views(), "view");
  RawShot shot{.left = {64, 48, 90}, .right = {64, 48, 90}, .pmd = {}};
  // A folder stands where the right picture goes.
  std::filesystem::create_directories(views() / "staged" / "view_002" / "right.pgm");
  refused(Exit::kFailure, [&] { kept.write("view_002", shot); });
  EXPECT_FALSE(std::filesystem::exists(views() / "view_002"));
  EXPECT_EQ(kept.count(), 1U);
  kept.write("view_002", shot);
  EXPECT_EQ(kept.count(), 2U);
  EXPECT_FALSE(std::filesystem::exists(views() / "staged"));
}

}  // namespace
}  // namespace stof::host
