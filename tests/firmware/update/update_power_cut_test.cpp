// Power that goes at any write of an update, of its confirmation and of the way back. What the disk
// holds then is made of the log of block writes: clean, torn, and in another order as far as
// flushes allow. The boot chooser takes a slot of it, which holds the old or the new release,
// whole.
#include <cstdio>
#include <functional>

#include <gtest/gtest.h>

#include "tests/firmware/update/update_support.h"
#include "tests/support/long_tests.h"

namespace stof::update {
namespace {

using namespace std::chrono_literals;
using hal::emu::Slots;
using test::Bytes;
using wire::SettingsResult;

struct Seen {
  int points = 0;
  int old = 0;
  int fresh = 0;
  int bad = 0;
};

class UpdatePowerCut : public testing::Test {
 protected:
  void judge(const Slots::Disk& disk) {
    ++seen_.points;
    const auto choice = test::choice_on(disk);
    if (!choice) {
      ++seen_.bad;
      return;
    }
    // The flag of a trial is lost with the power.
    const Bytes& slot = disk[static_cast<std::size_t>(part_of(started(*choice, false)))];
    const auto is = [&slot](const Bytes& content) {
      return std::equal(content.begin(), content.end(), slot.begin());
    };
    seen_.old += is(old_) ? 1 : 0;
    seen_.fresh += is(new_) ? 1 : 0;
    seen_.bad += is(old_) || is(new_) ? 0 : 1;
    // Whoever starts then comes to the end of another update.
    if (seen_.points % 32 == 0) {
      Slots slots(disk);
      Updater updater(test::setup_of(slots, started(*choice, false)));
      // Left: the cut came between the record and the restart, or in the trial.
      const upload::Versions versions = updater.versions();
      ASSERT_TRUE(versions.state == wire::UploadState::kSettled ||
                  versions.state == wire::UploadState::kLeft);
      ASSERT_TRUE(versions.state == wire::UploadState::kSettled || versions.former != 0);
      std::string said;
      ASSERT_EQ(test::send(updater, test::update_file(new_), said), SettingsResult::kOk) << said;
    }
  }

  // All states of the disk in which a cut may leave the writes from `from` on.
  void cut_everywhere(const Slots::Disk& before, const std::vector<Slots::Write>& log) {
    Slots::Disk disk = before;
    for (const Slots::Write& write : log) {
      judge(disk);  // before it
      const std::size_t sectors = (write.bytes.size() + kSectorBytes - 1) / kSectorBytes;
      const std::size_t step = test::long_tests() ? 1 : std::max<std::size_t>(sectors / 24, 1);
      for (std::size_t cut = 1; cut < sectors; cut += step) {
        judge(with(disk, write, [cut](std::size_t sector) { return sector < cut; }));
        judge(with(disk, write, [cut](std::size_t sector) { return sector >= cut; }));
        judge(with(disk, write, [cut](std::size_t sector) { return (sector * 7 + cut) % 3 == 0; }));
      }
      // Within the sectors, where there are few of them.
      if (write.part == hal::DiskPart::kBoot || write.bytes.size() <= kWrittenBytes) {
        const std::size_t far = test::long_tests() || write.bytes.size() == kSectorBytes ? 1 : 16;
        for (std::size_t byte = 1; byte < write.bytes.size(); byte += far) {
          judge(with_bytes(disk, write, 0, byte));
          judge(with_bytes(disk, write, byte, write.bytes.size()));
        }
      }
      disk = with_bytes(disk, write, 0, write.bytes.size());
    }
    judge(disk);
  }

  static Slots::Disk with(Slots::Disk disk, const Slots::Write& write,
                          const std::function<bool(std::size_t)>& is_written) {
    for (std::size_t at = 0; at < write.bytes.size(); at += kSectorBytes) {
      if (is_written(at / kSectorBytes)) {
        disk =
            with_bytes(std::move(disk), write, at, std::min(at + kSectorBytes, write.bytes.size()));
      }
    }
    return disk;
  }
  static Slots::Disk with_bytes(Slots::Disk disk, const Slots::Write& write, std::size_t from,
                                std::size_t to) {
    std::copy(write.bytes.begin() + static_cast<std::ptrdiff_t>(from),
              write.bytes.begin() + static_cast<std::ptrdiff_t>(to),
              disk[static_cast<std::size_t>(write.part)].begin() +
                  static_cast<std::ptrdiff_t>(write.offset + from));
    return disk;
  }

  // Half a minute of frames.
  static void confirm(Updater& updater) {
    Published published;
    for (hal::Duration t{}; t < 32s; t += 20ms) {
      ++published.rounds;
      ++published.frames;
      ++published.with_pair;
      ++published.with_pmd;
      updater.tick(hal::Time(1h) + t, published, 33ms);
    }
  }

  Bytes old_ = test::content_of(kChunkBytes, 1);
  Bytes new_ = test::content_of(2 * kChunkBytes + 777, 2);
  Seen seen_;
};

TEST_F(UpdatePowerCut, AtAnyWriteTheOldOrTheNewReleaseStarts) {
  const Slots::Disk first = test::disk_of(old_, test::content_of(1000, 3));
  Slots slots(first);
  std::string said;
  {
    Updater updater(test::setup_of(slots, Slot::kA));
    ASSERT_EQ(test::send(updater, test::update_file(new_), said), SettingsResult::kOk) << said;
  }
  for (const Slots::Write& write : slots.log()) {
    ASSERT_TRUE(
        write.flushed);  // one at a time, each on the medium before the next: no other order
  }
  cut_everywhere(first, slots.log());
  EXPECT_EQ(seen_.bad, 0);
  EXPECT_EQ(seen_.fresh, 0);  // nobody has confirmed it
  const int update = seen_.points;

  const Slots::Disk trial = slots.disk();
  std::size_t writes = slots.log().size();
  Updater next(test::setup_of(slots, Slot::kB));
  confirm(next);
  ASSERT_EQ(slots.log().size(), writes + 1);
  cut_everywhere(trial,
                 {slots.log().begin() + static_cast<std::ptrdiff_t>(writes), slots.log().end()});
  EXPECT_GT(seen_.fresh, 0);
  const int confirmed = seen_.points;

  const Slots::Disk settled_on_b = slots.disk();
  writes = slots.log().size();
  {
    Updater updater(test::setup_of(slots, Slot::kB));
    ASSERT_EQ(test::revert(updater, said), SettingsResult::kOk) << said;
  }
  Updater back(test::setup_of(slots, Slot::kA));
  confirm(back);
  EXPECT_EQ(*test::choice_on(slots.disk()), settled(Slot::kA));
  cut_everywhere(settled_on_b,
                 {slots.log().begin() + static_cast<std::ptrdiff_t>(writes), slots.log().end()});
  EXPECT_EQ(seen_.bad, 0);
  EXPECT_GE(seen_.points, 500);
  std::printf(
      "%d cuts: %d in the update, %d in its confirmation, %d on the way back; %d started the old "
      "release, %d the new one\n",
      seen_.points, update, confirmed - update, seen_.points - confirmed, seen_.old, seen_.fresh);
}

}  // namespace
}  // namespace stof::update
