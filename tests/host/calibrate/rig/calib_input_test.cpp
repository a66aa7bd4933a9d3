// Wrong input of `stof calib`: one line, the documented code, and nothing is left.
#include <algorithm>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "host/calibrate/calibration_store.h"
#include "host/cli/failure.h"
#include "host/cli/rig/calib_rig.h"
#include "tests/dataset/scratch.h"

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

}  // namespace
}  // namespace stof::host
