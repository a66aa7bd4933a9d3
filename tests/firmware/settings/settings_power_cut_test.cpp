#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "firmware/settings/saved_settings.h"
#include "firmware/settings/settings_trial.h"
#include "hal/linux/system/file_store.h"
#include "tests/support/power_cut.h"

namespace stof::settings {
namespace {

using namespace std::chrono_literals;
using hal::linux::FileStore;
using stof::test::power;

// Settings on a disk: a save, the next start, and what proves it.
class Life {
 public:
  explicit Life(const std::filesystem::path& folder)
      : name_((folder / "settings.json").string()),
        current_(name_),
        good_(name_ + ".good"),
        trial_(name_ + ".trial"),
        fixed_(name_ + ".limits") {}

  void begin(const Settings& proven) {
    power = {};
    ASSERT_EQ(save_document(current_, proven), Status::kOk);
    ASSERT_EQ(save_document(good_, proven), Status::kOk);
    ASSERT_EQ(count_failed_starts(trial_, proven, 1), Status::kOk);
  }
  // Up to a power cut.
  void change_to(const Settings& next) {
    if (save_fixed(fixed_, next) != Status::kOk || save_document(current_, next) != Status::kOk) {
      return;
    }
    const StartSettings started = start();
    if (power.cut || !started.on_trial) {
      return;
    }
    SettingsTrial trial(stores(), started.settings, false);
    trial.tick(hal::Time(1s), 1, &started.settings);
    trial.tick(hal::Time(1s) + SettingsTrial::kProof, 2, &started.settings);
  }
  StartSettings start() {
    std::array<char, 320> space;
    PagedWriter line(space);
    const StartSettings started = load_settings(stores(), name_, nullptr, line);
    told = line.text();
    return started;
  }
  // What was renamed before it was flushed is lost.
  static void power_comes_back() {
    if (!power.unflushed.empty()) {
      std::ofstream(power.unflushed, std::ios::trunc).close();
    }
    power = {};
  }

  std::string told;

 private:
  SettingsStores stores() { return {current_, good_, trial_, &fixed_}; }

  std::string name_;
  FileStore current_;
  FileStore good_;
  FileStore trial_;
  FileStore fixed_;
};

Settings numbered(int number) {
  Settings settings;
  settings.name = Text<kNameBytes + 1>(std::string(static_cast<std::size_t>(1 + number % 30), 'n'));
  settings.depth.max_range_mm = 1000 + number;
  settings.limits.least_range_mm = 600 + number;
  return settings;
}

TEST(SettingsPowerCut, AtEveryWriteLeavesOldOrNewAndNothingToTell) {
  std::string folder = (std::filesystem::temp_directory_path() / "stof_power_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  Life life(folder);
  int points = 0;
  int old = 0;
  for (int change = 0; points < 600; ++change) {
    const Settings before = numbered(change);
    const Settings after = numbered(1000 + change);
    for (int cut = 0;; ++cut) {
      life.begin(before);
      power = {.calls_left = cut};
      life.change_to(after);
      const bool was_cut = power.cut;
      Life::power_comes_back();
      const StartSettings started = life.start();
      ASSERT_TRUE(started.settings == before || started.settings == after) << cut;
      ASSERT_EQ(started.dropped, Dropped::kNot) << cut << ": " << life.told;
      ASSERT_EQ(life.told, "");
      if (!was_cut) {
        EXPECT_EQ(started.settings, after);
        EXPECT_FALSE(started.on_trial);
        break;
      }
      ++points;
      old += started.settings == before ? 1 : 0;
    }
  }
  EXPECT_GE(points, 600);
  EXPECT_GT(old, 100);
  EXPECT_LT(old, points);
  std::printf("%d cuts, %d of them left what was before\n", points, old);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace stof::settings
