// After a power cut in an install, or on the way back, in every state that the disk may be left in:
// the calibration from before or after.
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "hal/linux/system/file_store.h"
#include "tests/firmware/program/install_support.h"
#include "tests/support/disk_states.h"

namespace stof::firmware {
namespace {

using hal::linux::FileStore;
using test::Bytes;
using test::calibration_file;
using wire::SettingsResult;

const Bytes& factory() {
  static const Bytes file = calibration_file(100);
  return file;
}

// The fingerprint that a start in this folder finds; 0: what is there is no calibration.
std::uint32_t found_in(const std::filesystem::path& folder) {
  FileStore store((folder / "settings.calibration").string());
  bool unusable = false;
  const RigInfo rig = test::start_rig(factory(), &store, unusable);
  return unusable ? 0 : rig.fingerprint;
}

struct Seen {
  int states = 0;
  int old = 0;
  int wrong = 0;
};

Seen cut_everywhere(bool back, bool flushes) {
  const test::DiskFolders folders;
  FileStore store((folders.live() / "settings.calibration").string());
  bool unusable = false;
  RigInfo rig = test::start_rig(factory(), &store, unusable);
  test::Loop loop(rig);
  CalibrationInstaller installer({.rig = rig, .store = &store, .changes = nullptr, .sink = loop});
  std::string why;
  EXPECT_EQ(test::install(installer, calibration_file(110), why, {}), SettingsResult::kOk);
  const std::uint32_t before = rig.fingerprint;
  test::DiskRecording disk(folders.live());
  disk.flushes_nothing = !flushes;
  if (back) {
    std::array<char, 320> space{};
    settings::PagedWriter line(space);
    EXPECT_EQ(installer.revert({.peer = {}, .access = Access::kAdmin}, line), SettingsResult::kOk);
  } else {
    EXPECT_EQ(test::install(installer, calibration_file(120), why, {}), SettingsResult::kOk);
  }
  disk.stop();
  Seen seen;
  test::each_state_after_a_cut(disk, folders.after(), [&] {
    const std::uint32_t found = found_in(folders.after());
    ++seen.states;
    seen.old += found == before ? 1 : 0;
    seen.wrong += found == before || found == rig.fingerprint ? 0 : 1;
  });
  return seen;
}

TEST(CalibrationInstallDiskStates, AfterAnyCutTheOldOrTheNewOneIsThere) {
  int states = 0;
  for (const bool back : {false, true}) {
    const Seen seen = cut_everywhere(back, true);
    EXPECT_EQ(seen.wrong, 0) << back;
    EXPECT_GT(seen.old, 0) << back;
    EXPECT_LT(seen.old, seen.states) << back;
    states += seen.states;
  }
  std::printf("%d states of the disk\n", states);
}

// What the test above relies on.
TEST(CalibrationInstallDiskStates, OfADiskThatFlushesNothingItIsNoticed) {
  EXPECT_GT(cut_everywhere(false, false).wrong, 0);
}

}  // namespace
}  // namespace stof::firmware
