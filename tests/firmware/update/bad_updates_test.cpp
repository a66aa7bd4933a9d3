// A thousand update files that nobody may have: each is refused with one line, nothing of the
// running slot changes, and no start takes another one.
#include <cstdio>

#include <gtest/gtest.h>

#include "tests/firmware/update/update_support.h"
#include "tests/support/heap_guard.h"
#include "tests/support/random.h"

namespace stof::update {
namespace {

using test::Bytes;
using wire::SettingsResult;

class BadUpdates : public testing::Test {
 protected:
  // early: before anything is written.
  void refuse(const Bytes& file, const char* fact, bool early) {
    slots_.disk() = clean_;
    const std::size_t writes = slots_.log().size();
    const SettingsResult result = test::send(updater_, file, said_);
    ASSERT_NE(result, SettingsResult::kOk) << fact;
    ASSERT_EQ(said_.find('\n'), std::string::npos);
    ASSERT_NE(said_.find(fact), std::string::npos) << said_;
    ASSERT_EQ(slots_.disk()[1], clean_[1]);
    ASSERT_EQ(slots_.disk()[0], clean_[0]);
    ASSERT_EQ(early, slots_.log().size() == writes) << said_;
    ASSERT_EQ(updater_.versions().state, wire::UploadState::kSettled);
    if (!early) {  // part of it is there, and nobody can start it
      ASSERT_EQ(test::revert(updater_, said_), SettingsResult::kNotSaved);
    }
    ++refused_;
  }

  Bytes content_ = test::content_of(kChunkBytes + 3000, 3);
  Bytes good_ = test::update_file(content_);
  hal::emu::Slots::Disk clean_ =
      test::disk_of(test::content_of(5000, 1), test::content_of(9000, 2));
  hal::emu::Slots slots_{clean_};
  Updater updater_{test::setup_of(slots_, Slot::kA)};
  std::string said_;
  test::Random random_{1};
  int refused_ = 0;
};

TEST_F(BadUpdates, AThousandAreRefusedAndTheRunningSlotStays) {
  const auto number = [this](std::size_t below) { return random_.next() % below; };
  const std::size_t hashes = test::hashes_of(content_.size());
  for (int i = 0; i < 100; ++i) {
    Bytes unsigned_file = good_;
    std::fill_n(unsigned_file.begin() + 128, 64, std::byte{0});
    test::put_text(unsigned_file, 48, "v" + std::to_string(i));
    refuse(unsigned_file, "not signed", true);
    refuse(test::update_file(content_, {}, test::Maker(static_cast<unsigned char>(2 + i))),
           "not signed", true);
    refuse(test::update_file(content_, {.counter = static_cast<std::uint32_t>(i % 5)}),
           "downgrade counter", true);
    refuse(test::update_file(content_, {.board = i % 2 == 0 ? "rpi4" : "virt2"}), "is for board",
           true);
    refuse(test::update_file(content_, {.camera = i % 2 == 0 ? "imx296" : ""}), "is for board",
           true);
    // A bit of the head, of the hashes, and of a chunk.
    Bytes flipped = good_;
    flipped[number(kReleaseBytes)] ^= std::byte{1} << number(8);
    refuse(flipped, "", true);
    flipped = good_;
    flipped[kReleaseBytes + number(hashes)] ^= std::byte{1} << number(8);
    refuse(flipped, "list of hashes", true);
    flipped = good_;
    flipped[kReleaseBytes + hashes + number(content_.size())] ^= std::byte{1} << number(8);
    refuse(flipped, "has another hash", false);
    // Cut off, or longer than what was signed.
    Bytes cut = good_;
    cut.resize(1 + number(good_.size() - 1));
    refuse(cut, cut.size() > kReleaseBytes + kHashBytes ? "the signed size is" : "takes files of",
           true);
    Bytes longer = good_;
    longer.resize(good_.size() + 1 + number(1000));
    refuse(longer, "the signed size is", true);
    if (HasFatalFailure()) {
      return;
    }
  }
  // Too large for a slot, signed by the maker; and for anything.
  refuse(test::update_file(test::content_of(test::kRoom + 1, 4)), "", true);
  refuse(Bytes(4 * test::kRoom), "takes files of", true);
  EXPECT_GE(refused_, 1000);
  std::printf("%d bad update files refused\n", refused_);
  slots_.disk() = clean_;
  EXPECT_EQ(test::send(updater_, good_, said_), SettingsResult::kOk) << said_;
}

// A disk that keeps no log: what allocates then is the updater.
class QuietSlots final : public hal::Slots {
 public:
  explicit QuietSlots(hal::emu::Slots::Disk disk) : disk_(std::move(disk)) {}
  std::size_t bytes(hal::DiskPart part) const noexcept override {
    return disk_[static_cast<std::size_t>(part)].size();
  }
  Status read(hal::DiskPart part, std::size_t offset, std::span<std::byte> to) noexcept override {
    std::copy_n(at(part, offset), to.size(), to.begin());
    return Status::kOk;
  }
  void write(hal::DiskPart part, std::size_t offset,
             std::span<const std::byte> bytes) noexcept override {
    std::ranges::copy(bytes, at(part, offset));
  }
  Status progress() noexcept override { return Status::kOk; }

 private:
  Bytes::iterator at(hal::DiskPart part, std::size_t offset) noexcept {
    return disk_[static_cast<std::size_t>(part)].begin() + static_cast<std::ptrdiff_t>(offset);
  }
  hal::emu::Slots::Disk disk_;
};

TEST_F(BadUpdates, NeitherAGoodNorABadOneTakesMemory) {
  Bytes damaged = good_;
  damaged.back() ^= std::byte{1};
  QuietSlots quiet(clean_);
  Updater updater(test::setup_of(quiet, Slot::kA));
  test::heap_forbidden = true;
  const SettingsResult bad = test::send_quietly(updater, damaged);
  const SettingsResult good = test::send_quietly(updater, good_);
  for (int i = 0; i < 200; ++i) {
    updater.tick(hal::Time(std::chrono::milliseconds(20 * i)), {}, std::chrono::milliseconds(33));
  }
  test::heap_forbidden = false;
  EXPECT_EQ(bad, SettingsResult::kInvalid);
  EXPECT_EQ(good, SettingsResult::kOk);
}

}  // namespace
}  // namespace stof::update
