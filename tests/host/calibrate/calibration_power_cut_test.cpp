#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/calibration/calibration_file.h"
#include "host/calibrate/calibration_store.h"
#include "tests/support/power_cut.h"

namespace stof::host {
namespace {

using stof::test::power;
using Bytes = std::vector<std::byte>;

Bytes bytes_of(const dsp::Calibration& calibration) {
  Bytes bytes(wire::calibration_file_bytes(calibration));
  EXPECT_TRUE(wire::encode_calibration_file(calibration, bytes));
  return bytes;
}

class CalibrationPowerCut : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::temp_directory_path() / "stof_cal_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder_.data()), nullptr);
    file_ = folder_ + "/rig.cal";
    power = {};
  }
  void TearDown() override {
    power = {};
    std::filesystem::remove_all(folder_);
  }
  // What was renamed before it was flushed is lost.
  static void power_comes_back() {
    if (!power.unflushed.empty()) {
      std::ofstream(power.unflushed, std::ios::trunc).close();
    }
    power = {};
  }
  // Another one of each number.
  static dsp::Calibration numbered(int number) {
    dsp::Calibration calibration;
    calibration.stereo.left = {
        .width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240};
    calibration.stereo.baseline_m = 0.05 + 1e-4 * number;
    return calibration;
  }
  std::optional<Bytes> found() const {
    const auto stored = read_calibration(file_);
    EXPECT_TRUE(stored) << stored.error().message;
    return stored ? std::optional(bytes_of(stored->calibration)) : std::nullopt;
  }

  std::string folder_;
  std::string file_;
};

TEST_F(CalibrationPowerCut, AtEveryWriteLeavesOldOrNew) {
  ASSERT_TRUE(write_calibration(file_, numbered(0)));
  int points = 0;
  int old = 0;
  for (int change = 1; points < 600; ++change) {
    for (int cut = 0;; ++cut) {
      const Bytes before = bytes_of(numbered(change - 1));
      const Bytes after = bytes_of(numbered(change));
      ASSERT_TRUE(write_calibration(file_, numbered(change - 1)));
      power = {.calls_left = cut};
      const bool written = write_calibration(file_, numbered(change)).has_value();
      const bool was_cut = power.cut;
      power_comes_back();
      const std::optional<Bytes> now = found();
      ASSERT_TRUE(now == before || now == after) << cut;
      if (written) {
        ASSERT_EQ(now, after) << cut;
      }
      if (!was_cut) {
        ASSERT_TRUE(written);
        ASSERT_GT(cut, 3) << "not written by calls that may be cut";
        break;
      }
      ++points;
      old += now == before ? 1 : 0;
    }
  }
  EXPECT_GT(old, 100);
  EXPECT_LT(old, points);
  std::printf("%d cuts, %d of them left what was before\n", points, old);
}

}  // namespace
}  // namespace stof::host
