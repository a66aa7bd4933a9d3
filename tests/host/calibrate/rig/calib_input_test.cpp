// Wrong input of `stof calib`: one line, the documented code, and nothing is left.
#include <algorithm>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "dataset/files/file.h"
#include "host/calibrate/calibration_store.h"
#include "host/cli/failure.h"
#include "host/cli/rig/calib_rig.h"
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
  dsp::Calibration rig;
  rig.stereo.raw = test::true_pair();
  ASSERT_STREQ(dsp::complete(rig.stereo), "");
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
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
  dsp::Calibration rig;
  rig.stereo.raw = test::true_pair();
  ASSERT_STREQ(dsp::complete(rig.stereo), "");
  ASSERT_TRUE(write_calibration(file("rig.cal"), rig));
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

}  // namespace
}  // namespace stof::host
