// After a power cut, in every state that the disk may be left in: the keys from before or after,
// and nothing to tell.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "firmware/keys/keyring.h"
#include "hal/linux/system/file_store.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/support/disk_states.h"

namespace stof::keys {
namespace {

using hal::linux::FileStore;
using test::DiskRecording;
using test::numbered_key;

// The ring that a start in this folder finds, and what it has to tell.
struct Start {
  explicit Start(const std::filesystem::path& folder)
      : store((folder / "keys").string(), FileStore::Readers::kOwner),
        aside((folder / "keys.bad").string(), FileStore::Readers::kOwner) {
    std::array<char, 320> space;
    settings::PagedWriter line(space);
    ring.load("keys", line);
    told = line.text();
  }

  FileStore store;
  FileStore aside;
  Keyring ring{&store, &aside};
  std::string told;
};

struct Seen {
  int states = 0;
  int old = 0;
  int wrong = 0;
};

using Change = std::function<Status(Keyring&)>;

bool same(const wire::KeyTable& a, const wire::KeyTable& b) {
  return std::ranges::equal(a.all(), b.all());
}

// One change of fifteen keys, some sectors; every state that any cut in it may leave.
Seen cut_everywhere(const Change& change, bool flushes) {
  const test::DiskFolders folders;
  Start live(folders.live());
  for (std::uint32_t id = 1; id < kMostKeys; ++id) {
    EXPECT_EQ(live.ring.add(numbered_key(id, wire::Role::kTune)), Status::kOk);
  }
  const wire::KeyTable before = live.ring.keys();
  DiskRecording disk(folders.live());
  disk.flushes_nothing = !flushes;
  EXPECT_EQ(change(live.ring), Status::kOk);
  disk.stop();
  const wire::KeyTable next = live.ring.keys();
  EXPECT_FALSE(same(before, next));

  Seen seen;
  test::each_state_after_a_cut(disk, folders.after(), [&] {
    const Start found(folders.after());
    ++seen.states;
    seen.old += same(found.ring.keys(), before) ? 1 : 0;
    const bool either = same(found.ring.keys(), before) || same(found.ring.keys(), next);
    seen.wrong += either && found.told.empty() ? 0 : 1;
  });
  return seen;
}

wire::Secret another_secret() { return numbered_key(99).secret; }

const std::array<Change, 4>& changes() {
  static const std::array<Change, 4> all{
      [](Keyring& ring) { return ring.add(numbered_key(kMostKeys)); },
      [](Keyring& ring) { return ring.remove(1); },
      [](Keyring& ring) { return ring.replace(2, another_secret(), Shown::kFormer); },
      [](Keyring& ring) {  // renewed, and the new secret has signed
        const Status renewed = ring.replace(2, another_secret(), Shown::kFormer);
        ring.settle(2);
        return renewed;
      },
  };
  return all;
}

TEST(KeyDiskStates, AfterAnyCutTheOldOrTheNewKeysAreThereAndNothingToTell) {
  int states = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Seen seen = cut_everywhere(changes()[i], true);
    EXPECT_EQ(seen.wrong, 0) << i;
    EXPECT_GT(seen.old, 0) << i;
    EXPECT_LT(seen.old, seen.states) << i;
    states += seen.states;
  }
  EXPECT_GT(states, 60);
  std::printf("%d states of the disk\n", states);
}

// What the test above relies on: on a disk that flushes nothing, keys are lost; and two changes in
// one recording leave a third table between them.
TEST(KeyDiskStates, OfADiskThatFlushesNothingItIsNoticed) {
  EXPECT_GT(cut_everywhere(changes()[0], false).wrong, 0);
  EXPECT_GT(cut_everywhere(changes()[3], true).wrong, 0);
}

}  // namespace
}  // namespace stof::keys
