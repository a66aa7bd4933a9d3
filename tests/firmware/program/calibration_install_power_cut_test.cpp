// Power that goes before any write of an install or of the way back: the old or the new calibration
// is there at the next start, whole, and the factory's always.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "hal/linux/system/file_store.h"
#include "tests/firmware/program/install_support.h"
#include "tests/support/address_sanitizer.h"
#include "tests/support/power_cut.h"

namespace stof::firmware {
namespace {

using hal::linux::FileStore;
using test::Bytes;
using test::calibration_file;
using test::power;
using wire::SettingsResult;

// Each call is cut in each round. With sanitizers an install takes a tenth of a second: fewer
// rounds.
constexpr int kPoints = test::kAddressSanitizer ? 60 : 600;

TEST(CalibrationInstallPowerCut, AtEveryWriteLeavesOldOrNew) {
  std::string folder = (std::filesystem::temp_directory_path() / "stof_install_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const Bytes factory = calibration_file(100);
  power = {};
  int points = 0;
  int old = 0;
  for (int round = 0; points < kPoints; ++round) {
    for (int cut = 0;; ++cut) {
      FileStore store(folder + "/settings.json.calibration");
      bool unusable = false;
      RigInfo rig = test::start_rig(factory, &store, unusable);
      ASSERT_FALSE(unusable);
      test::Loop loop(rig);
      CalibrationInstaller installer(
          {.rig = rig, .store = &store, .changes = nullptr, .sink = loop});
      std::string why;
      const Bytes before = calibration_file(101 + (round + cut) % 50);
      ASSERT_EQ(test::install(installer, before, why, {}), SettingsResult::kOk) << why;
      const bool back = cut % 2 == 1;
      const Bytes after = back ? factory : calibration_file(160 + (round + cut) % 50);
      power = {.calls_left = cut / 2};
      SettingsResult done{};
      if (back) {
        std::array<char, 320> space{};
        settings::PagedWriter line(space);
        done = installer.revert({.peer = {}, .access = Access::kAdmin}, line);
      } else {
        done = test::install(installer, after, why, {});
      }
      const bool was_cut = power.cut;
      EXPECT_EQ(done == SettingsResult::kOk, !was_cut);
      // Whoever is told that it failed goes on with the old one.
      EXPECT_EQ(rig.fingerprint, wire::calibration_fingerprint(was_cut ? before : after));
      if (!power.unflushed.empty()) {
        std::ofstream(power.unflushed, std::ios::trunc).close();
      }
      power = {};
      const std::uint32_t found = test::start_rig(factory, &store, unusable).fingerprint;
      ASSERT_FALSE(unusable) << cut;
      ASSERT_TRUE(found == wire::calibration_fingerprint(before) ||
                  found == wire::calibration_fingerprint(after))
          << cut;
      points += was_cut ? 1 : 0;
      old += was_cut && found == wire::calibration_fingerprint(before) ? 1 : 0;
      if (!was_cut && cut > 20) {
        break;
      }
    }
  }
  EXPECT_GT(old, points / 6);
  EXPECT_LT(old, points);
  std::printf("%d cuts, %d of them left what was before\n", points, old);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace stof::firmware
