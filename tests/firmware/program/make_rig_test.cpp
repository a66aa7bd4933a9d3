// Which calibration a start begins with: the factory's, or the one that was installed.
#include <string>

#include <gtest/gtest.h>

#include "firmware/program/run_config.h"
#include "firmware/wire/calibration/calibration_file.h"
#include "tests/firmware/rig.h"

namespace stof::firmware {
namespace {

class MakeRig : public testing::Test {
 protected:
  // Of the rig's cameras, with this baseline.
  std::vector<std::byte> file_of(double baseline_m) const {
    dsp::Calibration calibration = rig_.board.calibration;
    calibration.stereo.baseline_m = baseline_m;
    std::vector<std::byte> file(wire::calibration_file_bytes(calibration));
    EXPECT_TRUE(wire::encode_calibration_file(calibration, file));
    return file;
  }
  std::expected<RigInfo, std::string> start(const InstalledCalibration& installed) {
    note_.clear();
    return make_rig(rig_.board, board::kConfig, {}, installed, note_);
  }
  static InstalledCalibration installed(std::vector<std::byte> file) {
    return {.place = "s.calibration", .file = std::move(file)};
  }

  test::Rig rig_;
  std::string note_;
};

TEST_F(MakeRig, WithoutAnInstalledOneTheBoardsOwnHolds) {
  const auto rig = start({});
  ASSERT_TRUE(rig) << rig.error();
  EXPECT_FALSE(rig->installed);
  EXPECT_EQ(rig->dropped, CalibrationDropped::kNot);
  EXPECT_EQ(note_, "");
  EXPECT_EQ(rig->factory, file_of(rig_.board.calibration.stereo.baseline_m));
  EXPECT_EQ(rig->fingerprint, wire::calibration_fingerprint(rig->factory));
}

TEST_F(MakeRig, AnInstalledOneHolds) {
  const std::vector<std::byte> file = file_of(0.3);
  const auto rig = start(installed(file));
  ASSERT_TRUE(rig) << rig.error();
  EXPECT_TRUE(rig->installed);
  EXPECT_EQ(rig->calibration.stereo.baseline_m, 0.3);
  EXPECT_EQ(rig->fingerprint, wire::calibration_fingerprint(file));
  EXPECT_NE(rig->factory, file);
  EXPECT_EQ(note_, "");
}

TEST_F(MakeRig, OfAnInstalledOneThatIsDamagedTheFactorysHoldsAndItIsTold) {
  std::vector<std::byte> file = file_of(0.3);
  file.pop_back();
  auto rig = start(installed(file));
  ASSERT_TRUE(rig) << rig.error();
  EXPECT_EQ(rig->dropped, CalibrationDropped::kUnusable);
  EXPECT_EQ(rig->calibration.stereo.baseline_m, rig_.board.calibration.stereo.baseline_m);
  EXPECT_EQ(note_,
            "s.calibration: not a calibration file, or damaged: export it again; the factory's "
            "calibration holds");
  rig = start({.place = "s.calibration", .file = {}, .unreadable = true});
  ASSERT_TRUE(rig) << rig.error();
  EXPECT_EQ(rig->dropped, CalibrationDropped::kUnreadable);
  EXPECT_NE(note_.find("no regular file"), std::string::npos);
}

// A board that knows only how its rig is meant to be.
TEST_F(MakeRig, WhereThereIsNoFactorysAnInstalledOneIsEnough) {
  rig_.board.nominal_calibration = true;
  rig_.board.allow_nominal_calibration = false;
  ASSERT_FALSE(start({}));
  EXPECT_NE(start({}).error().find("no calibration: give --calibration"), std::string::npos);
  const auto rig = start(installed(file_of(0.3)));
  ASSERT_TRUE(rig) << rig.error();
  EXPECT_TRUE(rig->installed);
  EXPECT_TRUE(rig->factory.empty());
  std::vector<std::byte> damaged = file_of(0.3);
  damaged[40] ^= std::byte{1};
  const auto refused = start(installed(damaged));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("damaged"), std::string::npos);
  EXPECT_NE(refused.error().find("no calibration: give --calibration"), std::string::npos);
}

}  // namespace
}  // namespace stof::firmware
