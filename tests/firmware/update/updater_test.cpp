#include "firmware/update/updater.h"

#include <chrono>

#include <gtest/gtest.h>

#include "tests/firmware/update/update_support.h"

namespace stof::update {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using wire::SettingsResult;
using wire::UploadState;

constexpr hal::Duration kFramePeriod = 33ms;

class UpdaterTest : public testing::Test {
 protected:
  // Whole seconds of a sensor that publishes everything, or nothing.
  void run(Updater& updater, hal::Duration time, bool frames = true) {
    for (const hal::Time end = now_ + time; now_ < end; now_ += 20ms) {
      ++published_.rounds;
      published_.frames += frames ? 1 : 0;
      published_.with_pair += frames ? 1 : 0;
      published_.with_pmd += frames ? 1 : 0;
      updater.tick(now_, published_, kFramePeriod);
    }
  }
  // What a start finds in a slot: its content, and nothing of what was there before behind it.
  bool holds(Slot slot, const Bytes& content) const {
    const Bytes& there = slots_.disk()[static_cast<std::size_t>(part_of(slot))];
    return std::equal(content.begin(), content.end(), there.begin());
  }

  Bytes a_ = test::content_of(test::kRoom - 100, 1);
  Bytes b_ = test::content_of(100'000, 2);
  Bytes new_ = test::content_of(2 * kChunkBytes + 77, 3);
  hal::emu::Slots slots_{test::disk_of(a_, b_)};
  hal::Time now_{1h};
  Published published_;
  std::string said_;
};

TEST_F(UpdaterTest, ASignedFileGoesToTheOtherSlotWhichIsTriedOnceAndConfirmed) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  EXPECT_EQ(updater.version(), "1.0");
  run(updater, 12s);
  const std::uint32_t former = updater.versions().in_force;
  EXPECT_NE(former, 0);
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk) << said_;
  EXPECT_EQ(updater.versions().state, UploadState::kRestarting);
  EXPECT_EQ(updater.restart(now_), Restart::kNone);  // the answer is still on its way
  run(updater, 2s);
  EXPECT_EQ(updater.restart(now_), Restart::kTrial);
  EXPECT_TRUE(holds(Slot::kA, a_));
  EXPECT_TRUE(holds(Slot::kB, new_));
  const BootChoice choice = *test::choice_on(slots_.disk());
  EXPECT_EQ(started(choice, false), Slot::kA);
  ASSERT_EQ(started(choice, true), Slot::kB);

  Updater next(test::setup_of(slots_, Slot::kB));
  EXPECT_EQ(next.version(), "2.0");
  EXPECT_EQ(next.versions().state, UploadState::kOnTrial);
  EXPECT_EQ(next.versions().former, former);
  run(next, 29s);
  EXPECT_EQ(started(*test::choice_on(slots_.disk()), false), Slot::kA);
  run(next, 2s);
  EXPECT_EQ(next.versions().state, UploadState::kSettled);
  EXPECT_EQ(next.restart(now_), Restart::kNone);
  EXPECT_EQ(*test::choice_on(slots_.disk()), settled(Slot::kB));
}

TEST_F(UpdaterTest, WhatCameOfATrialIsToldByTheReleaseThatRuns) {
  using What = TrialOutcome::What;
  Updater first(test::setup_of(slots_, Slot::kA));
  EXPECT_EQ(first.outcome(), TrialOutcome());  // B holds a release that nobody has tried
  run(first, 12s);
  ASSERT_EQ(test::send(first, test::update_file(new_), said_), SettingsResult::kOk) << said_;

  Updater second(test::setup_of(slots_, Slot::kB));
  const std::uint32_t tried = second.versions().in_force;
  EXPECT_EQ(second.outcome(), (TrialOutcome{.what = What::kRuns, .release = tried}));
  // It crashes.
  Updater third(test::setup_of(slots_, Slot::kA));
  EXPECT_EQ(third.outcome(), (TrialOutcome{.what = What::kLeft, .release = tried}));
  EXPECT_EQ(third.versions().state, UploadState::kLeft);
  run(third, 12s);
  ASSERT_EQ(test::send(third, test::update_file(b_), said_), SettingsResult::kOk) << said_;
  EXPECT_EQ(third.versions().state, UploadState::kRestarting);
  EXPECT_EQ(third.outcome(), TrialOutcome());  // another one is in that slot

  Updater fourth(test::setup_of(slots_, Slot::kB));
  const std::uint32_t good = fourth.versions().in_force;
  EXPECT_NE(good, tried);
  run(fourth, 32s);
  EXPECT_EQ(fourth.outcome(), (TrialOutcome{.what = What::kConfirmed, .release = good}));
  // The former release lies in the other slot, and was not left.
  Updater fifth(test::setup_of(slots_, Slot::kB));
  EXPECT_EQ(fifth.outcome(), TrialOutcome());
  EXPECT_EQ(fifth.versions().state, UploadState::kSettled);

  run(fifth, 12s);
  ASSERT_EQ(test::revert(fifth, said_), SettingsResult::kOk) << said_;
  Updater reverted(test::setup_of(slots_, Slot::kA));
  EXPECT_EQ(reverted.outcome().what, What::kRuns);
  run(reverted, 80s, false);
  EXPECT_EQ(reverted.outcome().what, What::kLeft);
  Updater last(test::setup_of(slots_, Slot::kB));
  EXPECT_EQ(last.outcome(),
            (TrialOutcome{.what = What::kLeft, .release = reverted.versions().in_force}));
}

TEST_F(UpdaterTest, InStandbyWhatWasPublishedBeforeItCounts) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  run(updater, 12s);
  published_.standby = true;
  run(updater, 60s, false);
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk) << said_;
  published_.standby = false;
  Updater next(test::setup_of(slots_, Slot::kB));
  run(next, 60s, false);  // no frames: not good enough
  EXPECT_EQ(next.outcome().what, TrialOutcome::What::kRuns);
}

TEST_F(UpdaterTest, ARecordWithoutAReadableNumberIsOfTrialZero) {
  RecordBytes bytes = write_record({}, kAllShown, 7);
  EXPECT_EQ(read_record(bytes).trial, 7);
  bytes[512 + 16] ^= std::byte{1};
  EXPECT_EQ(read_record(bytes).trial, 0);
  EXPECT_EQ(read_record(bytes).before, kAllShown);
}

TEST_F(UpdaterTest, ATrialThatPublishesNothingIsLeft) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  run(updater, 12s);
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk) << said_;
  Updater next(test::setup_of(slots_, Slot::kB));
  run(next, 80s, false);
  EXPECT_EQ(next.restart(now_), Restart::kUsual);
  EXPECT_EQ(started(*test::choice_on(slots_.disk()), false), Slot::kA);
}

TEST_F(UpdaterTest, ASensorThatPublishedNothingBeforeIsConfirmedWithoutFrames) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  run(updater, 12s, false);
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk) << said_;
  Updater next(test::setup_of(slots_, Slot::kB));
  run(next, 32s, false);
  EXPECT_EQ(next.versions().state, UploadState::kSettled);
}

TEST_F(UpdaterTest, TheLetterOfTheSlotIsPutWhereTheMakerSays) {
  for (const std::uint32_t at :
       {0U, 65'535U, 65'536U, static_cast<std::uint32_t>(new_.size() - 1)}) {
    hal::emu::Slots slots(test::disk_of(a_, b_));
    Updater updater(test::setup_of(slots, Slot::kA));
    ASSERT_EQ(test::send(updater, test::update_file(new_, {.letter_at = at}), said_),
              SettingsResult::kOk)
        << said_;
    Bytes with_letter = new_;
    with_letter[at] = std::byte{'b'};
    EXPECT_TRUE(std::equal(with_letter.begin(), with_letter.end(), slots.disk()[2].begin())) << at;
  }
}

TEST_F(UpdaterTest, ASlowCardIsWaitedForAndWrittenTheSame) {
  slots_.delay = 100;
  Updater updater(test::setup_of(slots_, Slot::kA));
  int repeats = 0;
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_, &repeats), SettingsResult::kOk)
      << said_;
  EXPECT_GT(repeats, 50);
  EXPECT_TRUE(holds(Slot::kB, new_));
}

TEST_F(UpdaterTest, EverySizeOfTheLastChunkIsWritten) {
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{700}, kChunkBytes - 1, kChunkBytes,
                                  kChunkBytes + 1, test::kRoom - 1, test::kRoom}) {
    hal::emu::Slots slots(test::disk_of(a_, b_));
    slots.delay = 3;
    Updater updater(test::setup_of(slots, Slot::kA));
    const Bytes content = test::content_of(bytes, 9);
    ASSERT_EQ(test::send(updater, test::update_file(content), said_), SettingsResult::kOk)
        << bytes << said_;
    EXPECT_TRUE(std::equal(content.begin(), content.end(), slots.disk()[2].begin())) << bytes;
  }
}

TEST_F(UpdaterTest, ACardThatTakesNoMoreIsToldAndTheRunningReleaseStays) {
  for (int writes = 0; writes < 5; ++writes) {
    hal::emu::Slots slots(test::disk_of(a_, b_));
    slots.breaks_after = writes;
    Updater updater(test::setup_of(slots, Slot::kA));
    EXPECT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kNotSaved);
    EXPECT_NE(said_.find("card takes no writes"), std::string::npos) << said_;
    EXPECT_EQ(*test::choice_on(slots.disk()), settled(Slot::kA));
    EXPECT_EQ(updater.versions().state, UploadState::kSettled);
  }
}

TEST_F(UpdaterTest, ACardThatGivesOtherBytesBackIsToldAndItsSlotIsNotTried) {
  for (const std::size_t byte : {std::size_t{0}, kChunkBytes - 1, kChunkBytes, new_.size() - 1}) {
    hal::emu::Slots slots(test::disk_of(a_, b_));
    slots.worn_byte = byte;
    Updater updater(test::setup_of(slots, Slot::kA));
    EXPECT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kNotSaved);
    EXPECT_NE(said_.find("gives back other bytes"), std::string::npos) << said_;
    EXPECT_EQ(updater.versions().state, UploadState::kSettled);
    EXPECT_EQ(test::revert(updater, said_), SettingsResult::kNotSaved);
    EXPECT_NE(said_.find("no whole release"), std::string::npos) << said_;
    slots.worn_byte.reset();  // another try
    EXPECT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk) << said_;
  }
}

TEST_F(UpdaterTest, AnUpdateWhileATrialRunsIsRefused) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk);
  EXPECT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kNotSaved);
  EXPECT_NE(said_.find("restarts"), std::string::npos) << said_;
  Updater next(test::setup_of(slots_, Slot::kB));
  const std::size_t writes = slots_.log().size();
  EXPECT_EQ(test::send(next, test::update_file(new_), said_), SettingsResult::kNotSaved);
  EXPECT_NE(said_.find("on trial"), std::string::npos) << said_;
  EXPECT_EQ(test::revert(next, said_), SettingsResult::kNotSaved);
  EXPECT_EQ(slots_.log().size(), writes);
}

TEST_F(UpdaterTest, WhereNoSlotCanBeTriedALineSaysWhy) {
  struct Case {
    UpdaterSetup setup;
    const char* said;
  };
  UpdaterSetup no_try = test::setup_of(slots_, Slot::kA);
  no_try.can_try = false;
  UpdaterSetup old_loader = test::setup_of(slots_, Slot::kA);
  old_loader.old_loader = true;
  UpdaterSetup no_key = test::setup_of(slots_, Slot::kA);
  no_key.keys = {};
  hal::emu::Slots without(test::disk_of(a_, b_));
  without.disk()[0].assign(4096, std::byte{0});
  for (const Case& c : {Case{no_try, "kernel cannot start the other slot"},
                        {old_loader, "EEPROM is too old"},
                        {no_key, "maker's key"},
                        {test::setup_of(without, Slot::kA), "autoboot.txt"},
                        {{.board = "virt"}, "no image of scripts/image"}}) {
    Updater updater(c.setup);
    EXPECT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kNotSaved);
    EXPECT_NE(said_.find(c.said), std::string::npos) << said_;
    EXPECT_EQ(test::revert(updater, said_), SettingsResult::kNotSaved);
    EXPECT_NE(said_.find(c.said), std::string::npos) << said_;
  }
  EXPECT_TRUE(slots_.log().empty());
}

TEST_F(UpdaterTest, ARevertTriesTheFormerRelease) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  run(updater, 12s);
  ASSERT_EQ(test::revert(updater, said_), SettingsResult::kOk) << said_;
  EXPECT_EQ(test::revert(updater, said_), SettingsResult::kOk);  // an answer that was lost
  run(updater, 2s);
  EXPECT_EQ(updater.restart(now_), Restart::kTrial);
  Updater next(test::setup_of(slots_, Slot::kB));
  EXPECT_EQ(next.version(), "0.9");
  run(next, 32s);
  EXPECT_EQ(*test::choice_on(slots_.disk()), settled(Slot::kB));
}

TEST_F(UpdaterTest, ARevertToNothingOrToPartOfAReleaseIsRefused) {
  {
    Updater updater(test::setup_of(slots_, Slot::kA));
    Bytes damaged = test::update_file(new_);
    damaged.back() ^= std::byte{1};
    EXPECT_EQ(test::send(updater, damaged, said_), SettingsResult::kInvalid);
    EXPECT_EQ(test::revert(updater, said_), SettingsResult::kNotSaved);
    EXPECT_NE(said_.find("no whole release in slot b"), std::string::npos) << said_;
  }
  hal::emu::Slots older(test::disk_of(a_, b_));
  test::install(older.disk(), Slot::kB, b_, {.counter = 4});
  Updater updater(test::setup_of(older, Slot::kA));
  EXPECT_EQ(test::revert(updater, said_), SettingsResult::kInvalid);
  EXPECT_NE(said_.find("downgrade counter"), std::string::npos) << said_;
}

// The sector was torn when a trial was confirmed: both numbers name the running slot.
TEST_F(UpdaterTest, ATornSectorIsMadeWholeBeforeTheNextTrial) {
  write_choice({.usual = Slot::kA, .trial = Slot::kA},
               std::span(slots_.disk()[0]).subspan<test::kChoiceAt, kSectorBytes>());
  Updater updater(test::setup_of(slots_, Slot::kA));
  EXPECT_EQ(updater.versions().state, UploadState::kSettled);
  ASSERT_EQ(test::send(updater, test::update_file(new_), said_), SettingsResult::kOk) << said_;
  EXPECT_EQ(*test::choice_on(slots_.disk()), settled(Slot::kA));
}

TEST_F(UpdaterTest, TheSameCounterAndTheSameReleaseAreTaken) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  EXPECT_EQ(test::send(updater, test::update_file(a_, {.version = "1.0"}), said_),
            SettingsResult::kOk)
      << said_;
}

TEST_F(UpdaterTest, KeysRotateBySignaturesOfAnyThatTheReleaseKnows) {
  const test::Maker next(2);
  const std::array keys{test::maker().key, next.key};
  UpdaterSetup setup = test::setup_of(slots_, Slot::kA);
  setup.keys = keys;
  Updater both(setup);
  EXPECT_EQ(test::send(both, test::update_file(new_, {}, next), said_), SettingsResult::kOk);
  hal::emu::Slots slots(test::disk_of(a_, b_));
  Updater old(test::setup_of(slots, Slot::kA));
  EXPECT_EQ(test::send(old, test::update_file(new_, {}, next), said_), SettingsResult::kInvalid);
}

TEST_F(UpdaterTest, AnUploadThatIsLeftAndBegunAnewIsWhole) {
  Updater updater(test::setup_of(slots_, Slot::kA));
  slots_.delay = 40;
  const Bytes file = test::update_file(new_);
  std::array<char, 320> space{};
  settings::PagedWriter why(space);
  ASSERT_EQ(updater.begin(static_cast<std::uint32_t>(file.size()), why), SettingsResult::kOk);
  for (std::size_t at = 0; at < 70'000; at += 960) {
    ASSERT_EQ(updater.write(std::span(file).subspan(at, 960), why), SettingsResult::kOk);
  }
  ASSERT_EQ(test::send(updater, file, said_), SettingsResult::kOk) << said_;
  EXPECT_TRUE(holds(Slot::kB, new_));
}

}  // namespace
}  // namespace stof::update
