// After a power cut, in every state that the disk may be left in: old or new settings, and nothing
// to tell.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "firmware/settings/saved_settings.h"
#include "firmware/settings/settings_trial.h"
#include "hal/linux/system/file_store.h"
#include "tests/support/disk_states.h"

namespace stof::settings {
namespace {

using namespace std::chrono_literals;
using hal::linux::FileStore;
using test::DiskRecording;

Settings numbered(int number) {
  Settings settings;
  settings.name = Text<kNameBytes + 1>(std::string(static_cast<std::size_t>(1 + number % 30), 'n'));
  settings.depth.max_range_mm = 1000 + number;
  return settings;
}

struct Stores {
  explicit Stores(const std::filesystem::path& folder)
      : name((folder / "settings.json").string()),
        current(name),
        good(name + ".good"),
        trial(name + ".trial") {}
  StartSettings start() {
    std::array<char, 320> space;
    PagedWriter line(space);
    return load_settings({current, good, trial}, name, nullptr, line);
  }

  std::string name;
  FileStore current;
  FileStore good;
  FileStore trial;
};

struct Seen {
  int states = 0;
  int old = 0;
  int wrong = 0;
};

// A save, the start after it and what proves it; every state that any cut in it may leave.
Seen cut_everywhere(const Settings& before, const Settings& next, bool flushes) {
  const test::DiskFolders folders;
  Stores stores(folders.live());
  EXPECT_EQ(save_document(stores.current, before), Status::kOk);
  EXPECT_EQ(save_document(stores.good, before), Status::kOk);
  DiskRecording disk(folders.live());
  disk.flushes_nothing = !flushes;
  EXPECT_EQ(save_document(stores.current, next), Status::kOk);
  const StartSettings started = stores.start();
  SettingsTrial trial({stores.current, stores.good, stores.trial}, started.settings, false);
  trial.tick(hal::Time(1s), 1, &started.settings);
  trial.tick(hal::Time(1s) + SettingsTrial::kProof, 2, &started.settings);
  disk.stop();
  EXPECT_GT(disk.calls(), 8U);

  Seen seen;
  test::each_state_after_a_cut(disk, folders.after(), [&] {
    const StartSettings found = Stores(folders.after()).start();
    ++seen.states;
    seen.old += found.settings == before ? 1 : 0;
    const bool either = found.settings == before || found.settings == next;
    seen.wrong += either && found.dropped == Dropped::kNot ? 0 : 1;
  });
  return seen;
}

TEST(SettingsDiskStates, AfterAnyCutOldOrNewIsThereAndNothingToTell) {
  int states = 0;
  for (int change = 0; change < 3; ++change) {
    const Seen seen = cut_everywhere(numbered(change), numbered(1000 + change), true);
    EXPECT_EQ(seen.wrong, 0) << change;
    EXPECT_GT(seen.old, 0);
    EXPECT_LT(seen.old, seen.states);
    states += seen.states;
  }
  EXPECT_GT(states, 100);
  std::printf("%d states of the disk\n", states);
}

// What the test above relies on: on a disk that flushes nothing, settings are lost.
TEST(SettingsDiskStates, OfADiskThatFlushesNothingItIsNoticed) {
  EXPECT_GT(cut_everywhere(numbered(1), numbered(2), false).wrong, 0);
}

}  // namespace
}  // namespace stof::settings
