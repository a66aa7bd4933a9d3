#include "firmware/program/calibration_installer.h"

#include <chrono>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "hal/emu/devices/store.h"
#include "tests/firmware/program/install_support.h"
#include "tests/support/heap_guard.h"

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::calibration_file;
using wire::SettingsResult;

class CalibrationInstallerTest : public testing::Test {
 protected:
  SettingsResult install(const Bytes& file) { return test::install(installer_, file, said_, now_); }
  SettingsResult revert() {
    std::array<char, 320> space{};
    settings::PagedWriter why(space);
    const SettingsResult result =
        installer_.revert({.peer = {}, .now = now_, .access = Access::kAdmin}, why);
    said_ = why.text();
    return result;
  }
  void expect_in_force(const Bytes& file, int number) {
    EXPECT_EQ(installer_.versions().in_force, wire::calibration_fingerprint(file));
    EXPECT_EQ(rig_.fingerprint, wire::calibration_fingerprint(file));
    EXPECT_EQ(rig_.calibration.stereo.baseline_m, number / 1000.0);
    ASSERT_EQ(rig_.calibration.pmd.fixed_pattern.size(), 48U);
    for (const std::int16_t value : rig_.calibration.pmd.fixed_pattern) {
      ASSERT_EQ(value, number);
    }
  }
  void expect_refused_unchanged(const Bytes& file, const char* why,
                                SettingsResult as = SettingsResult::kInvalid) {
    const Bytes stored = store_.bytes();
    const int saves = store_.saves();
    const std::uint32_t installs = rig_.installs;
    EXPECT_EQ(install(file), as);
    EXPECT_NE(said_.find(why), std::string::npos) << said_;
    EXPECT_EQ(store_.bytes(), stored);
    EXPECT_EQ(store_.saves(), saves);
    EXPECT_EQ(rig_.installs, installs);
    EXPECT_EQ(loop_.uses, static_cast<int>(installs));
    EXPECT_EQ(changes_.size(), installs);
  }

  Bytes factory_ = calibration_file(100);
  Bytes other_ = calibration_file(120);
  hal::emu::Store store_;
  ChangeRing changes_;
  bool unusable_ = false;
  RigInfo rig_ = test::start_rig(factory_, &store_, unusable_);
  test::Loop loop_{rig_};
  CalibrationInstaller installer_{
      {.rig = rig_, .store = &store_, .changes = &changes_, .sink = loop_}};
  hal::Time now_{1s};
  std::string said_;
};

TEST_F(CalibrationInstallerTest, KeepsItAndRunsWithIt) {
  expect_in_force(factory_, 100);
  EXPECT_EQ(install(other_), SettingsResult::kOk) << said_;
  expect_in_force(other_, 120);
  EXPECT_EQ(installer_.versions().former, wire::calibration_fingerprint(factory_));
  EXPECT_EQ(store_.bytes(), other_);
  EXPECT_EQ(loop_.uses, 1);
  EXPECT_EQ(loop_.used.stereo.baseline_m, 0.12);
  EXPECT_EQ(rig_.installs, 1U);
  EXPECT_TRUE(rig_.installed);
  bool unusable = false;
  EXPECT_EQ(test::start_rig(factory_, &store_, unusable).fingerprint, rig_.fingerprint);
}

TEST_F(CalibrationInstallerTest, TellsWhatCameInPlaceOfWhat) {
  EXPECT_EQ(install(other_), SettingsResult::kOk);
  const auto event = changes_.pop();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, EventKind::kCalibrationChanged);
  EXPECT_EQ(event->value, wire::calibration_fingerprint(other_));
  EXPECT_EQ(event->former, wire::calibration_fingerprint(factory_));
}

TEST_F(CalibrationInstallerTest, GoesBackToTheFactorysAfterAnyNumber) {
  for (const int number : {110, 130, 140}) {
    EXPECT_EQ(install(calibration_file(number)), SettingsResult::kOk);
  }
  EXPECT_EQ(revert(), SettingsResult::kOk) << said_;
  expect_in_force(factory_, 100);
  EXPECT_EQ(installer_.versions().former, wire::calibration_fingerprint(calibration_file(140)));
  EXPECT_FALSE(rig_.installed);
  std::array<std::byte, 1> space{};
  EXPECT_FALSE(store_.load(space).value());
  EXPECT_EQ(store_.aside(), calibration_file(140));  // for somebody to look at
  EXPECT_EQ(revert(), SettingsResult::kOk);          // once more: nothing is done
  EXPECT_EQ(loop_.uses, 4);
  EXPECT_EQ(install(other_), SettingsResult::kOk);
  expect_in_force(other_, 120);
}

TEST_F(CalibrationInstallerTest, WhatIsNoCalibrationOfThisRigChangesNothing) {
  expect_refused_unchanged(calibration_file(120, 65, 48), "made for cameras of 65x48");
  expect_refused_unchanged(Bytes(100), "not a calibration file");
  Bytes damaged = other_;
  for (std::size_t at = 0; at < damaged.size(); at += 37) {
    damaged[at] ^= std::byte{4};
    EXPECT_EQ(install(damaged), SettingsResult::kInvalid) << at;
    damaged[at] ^= std::byte{4};
  }
  expect_in_force(factory_, 100);
  loop_.answer = SettingsResult::kInvalid;
  expect_refused_unchanged(other_, "no room");
  expect_in_force(factory_, 100);
  EXPECT_EQ(store_.saves(), 0);
}

TEST_F(CalibrationInstallerTest, OfAnotherModulationIsRefusedWhereTheCameraHasItsOwn) {
  rig_.needs.modulation = dsp::Hertz{12'345};
  expect_refused_unchanged(other_, "12345 Hz");
}

TEST_F(CalibrationInstallerTest, WaitsUntilTheLastOneIsInForce) {
  loop_.in_force = false;
  expect_refused_unchanged(other_, "not in force yet", SettingsResult::kBusy);
  loop_.in_force = true;
  loop_.answer = SettingsResult::kBusy;
  expect_refused_unchanged(other_, "", SettingsResult::kBusy);
  loop_.answer = SettingsResult::kOk;
  EXPECT_EQ(install(other_), SettingsResult::kOk);
}

TEST_F(CalibrationInstallerTest, AMediumThatTakesNothingChangesNothing) {
  EXPECT_EQ(install(other_), SettingsResult::kOk);
  store_.break_down(true);
  EXPECT_EQ(install(calibration_file(140)), SettingsResult::kNotSaved);
  EXPECT_NE(said_.find("cannot be written"), std::string::npos);
  expect_in_force(other_, 120);
  EXPECT_EQ(revert(), SettingsResult::kNotSaved);
  expect_in_force(other_, 120);
  EXPECT_EQ(loop_.uses, 1);
  store_.break_down(false);
  EXPECT_EQ(revert(), SettingsResult::kOk);
}

TEST_F(CalibrationInstallerTest, TenTimesThenOnceAMinute) {
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(install(calibration_file(110 + i)), SettingsResult::kOk) << i;
  }
  EXPECT_EQ(install(other_), SettingsResult::kNotSaved);
  EXPECT_NE(said_.find("one a minute"), std::string::npos) << said_;
  now_ += 60s;
  EXPECT_EQ(install(other_), SettingsResult::kOk);
  EXPECT_EQ(install(factory_), SettingsResult::kNotSaved);
}

TEST_F(CalibrationInstallerTest, LongerThanAnyOfThisBoardIsRefusedAtItsBegin) {
  std::array<char, 320> space{};
  settings::PagedWriter why(space);
  const std::size_t most = most_calibration_bytes(board::kConfig);
  EXPECT_EQ(installer_.begin(static_cast<std::uint32_t>(most), why), SettingsResult::kOk);
  EXPECT_EQ(installer_.begin(static_cast<std::uint32_t>(most + 1), why), SettingsResult::kInvalid);
}

TEST_F(CalibrationInstallerTest, WithoutAFileForItSaysSo) {
  CalibrationInstaller none({.rig = rig_, .store = nullptr, .changes = nullptr, .sink = loop_});
  std::array<char, 320> space{};
  settings::PagedWriter why(space);
  EXPECT_EQ(none.begin(100, why), SettingsResult::kNotSaved);
  EXPECT_EQ(why.text(), "calibration: this sensor keeps none: start stofd with --settings FILE");
}

TEST_F(CalibrationInstallerTest, WithoutAFactoryCalibrationThereIsNoWayBack) {
  EXPECT_EQ(install(other_), SettingsResult::kOk);
  rig_.factory.clear();
  EXPECT_EQ(revert(), SettingsResult::kNotSaved);
  EXPECT_NE(said_.find("no factory calibration"), std::string::npos);
  expect_in_force(other_, 120);
}

// A medium that allocates nothing.
class FixedStore final : public hal::Store {
 public:
  Result<std::optional<std::size_t>> load(std::span<std::byte> /*space*/) noexcept override {
    return std::optional(bytes_);
  }
  Status save(std::span<const std::byte> bytes) noexcept override {
    bytes_ = bytes.size();
    return Status::kOk;
  }
  Status set_aside() noexcept override { return Status::kOk; }

 private:
  std::size_t bytes_ = 0;
};

TEST_F(CalibrationInstallerTest, AllocatesNothing) {
  FixedStore store;
  CalibrationInstaller installer(
      {.rig = rig_, .store = &store, .changes = &changes_, .sink = loop_});
  const Bytes wrong = calibration_file(120, 65, 48);
  std::array<char, 320> space{};
  settings::PagedWriter why(space);
  const Requester by{.peer = {}, .now = now_, .access = Access::kAdmin};
  test::heap_forbidden = true;
  for (const Bytes* const file : {&std::as_const(other_), &wrong, &std::as_const(factory_)}) {
    static_cast<void>(installer.begin(static_cast<std::uint32_t>(file->size()), why));
    static_cast<void>(installer.write(*file, why));
    static_cast<void>(installer.commit(by, why));
  }
  const SettingsResult back = installer.revert(by, why);
  test::heap_forbidden = false;
  EXPECT_EQ(back, SettingsResult::kOk);
  EXPECT_EQ(rig_.installs, 3U);
}

}  // namespace
}  // namespace stof::firmware
