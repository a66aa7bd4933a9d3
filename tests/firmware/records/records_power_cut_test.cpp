// Power that goes at any write of settings, keys and calibration, and while what a cut took is
// mended. What the partition holds then is made of the log of its writes: clean, torn, in another
// order as far as flushes allow, and with the whole erase block gone. Each document is the old or
// the new one, all others are as they were.
#include <algorithm>
#include <cstdio>
#include <functional>

#include <gtest/gtest.h>

#include "hal/emu/devices/disk.h"
#include "tests/firmware/records/records_support.h"

namespace stof::records {
namespace {

using hal::emu::Disk;
using test::All;
using test::Bytes;
using test::Read;

constexpr std::size_t kSector = 512;

enum class Torn : std::uint8_t { kNothing, kFirst, kLast, kEveryThird, kWhole };

// What came of a write: sectors of it.
struct Part {
  Torn torn = Torn::kWhole;
  std::size_t cut = 0;

  bool has(std::size_t sector) const {
    switch (torn) {
      case Torn::kNothing:
        return false;
      case Torn::kFirst:
        return sector < cut;
      case Torn::kLast:
        return sector >= cut;
      case Torn::kEveryThird:
        return (sector * 7 + cut) % 3 == 0;
      case Torn::kWhole:
        break;
    }
    return true;
  }
};

struct Seen {
  int points = 0;
  int erased = 0;
  int old = 0;
  int fresh = 0;
  int bad = 0;
};

class RecordsPowerCut : public testing::Test {
 protected:
  // Does it on the disk, and then again with a cut at every write.
  void change(const std::function<Status(RecordDisk&)>& what) {
    disk_.log().clear();
    ASSERT_EQ(what(records_), Status::kOk);
    RecordDisk done(disk_);
    after_ = test::read_all(done);
    const Bytes end = disk_.content();
    const std::vector<Disk::Call> log = disk_.log();
    disk_.content() = base_;
    cut_everywhere(log);
    disk_.content() = end;
    base_ = end;
    before_ = after_;
  }

  void cut_everywhere(const std::vector<Disk::Call>& log) {
    std::vector<const Disk::Call*> open;  // not flushed
    for (const Disk::Call& call : log) {
      if (call.bytes.empty()) {
        for (const Disk::Call* const done : open) {
          put(*done, {}, base_);
          put(*done, {}, disk_.content());
        }
        open.clear();
        judge(false);
        continue;
      }
      open.push_back(&call);
      cut(open);
    }
  }

  void cut(const std::vector<const Disk::Call*>& open) {
    const Disk::Call& last = *open.back();
    const std::size_t sectors = (last.bytes.size() + kSector - 1) / kSector;
    const std::size_t step = std::max<std::size_t>(sectors / 8, 1);
    // In their order.
    for (std::size_t at = 0; at <= sectors; at += step) {
      with(open, {.torn = Torn::kFirst, .cut = at}, {});
    }
    // The last of them before the others.
    for (const Torn others : {Torn::kNothing, Torn::kEveryThird}) {
      with(open, {}, {.torn = others});
      with(open, {.torn = Torn::kEveryThird, .cut = 1}, {.torn = others, .cut = 2});
    }
    for (std::size_t at = 1; at < sectors; at += step) {
      with(open, {.torn = Torn::kLast, .cut = at}, {});
      with(open, {.torn = Torn::kEveryThird, .cut = at}, {.torn = Torn::kLast, .cut = at});
    }
    // The erase block goes with it.
    for (const std::byte content : {std::byte{0}, std::byte{0xFF}, std::byte{0xA5}}) {
      const std::size_t begin = last.offset / kEraseBlockBytes * kEraseBlockBytes;
      touch(begin, kEraseBlockBytes);
      std::fill_n(disk_.content().begin() + static_cast<std::ptrdiff_t>(begin), kEraseBlockBytes,
                  content);
      ++seen_.erased;
      judge(true);
    }
  }

  // The last write as `of_last` says, those before it, which are not flushed, as `of_others`.
  void with(const std::vector<const Disk::Call*>& open, Part of_last, Part of_others) {
    for (const Disk::Call* const call : open) {
      put(*call, call == open.back() ? of_last : of_others, disk_.content());
      touch(call->offset, call->bytes.size());
    }
    judge(true);
  }

  static void put(const Disk::Call& call, Part part, Bytes& to) {
    for (std::size_t at = 0; at < call.bytes.size(); at += kSector) {
      if (part.has(at / kSector)) {
        const auto begin = static_cast<std::ptrdiff_t>(at);
        const auto end = static_cast<std::ptrdiff_t>(std::min(at + kSector, call.bytes.size()));
        std::copy(call.bytes.begin() + begin, call.bytes.begin() + end,
                  to.begin() + static_cast<std::ptrdiff_t>(call.offset) + begin);
      }
    }
  }

  void touch(std::size_t begin, std::size_t count) { touched_.emplace_back(begin, count); }

  void judge(bool is_cut) {
    disk_.log().clear();
    seen_.points += is_cut ? 1 : 0;
    RecordDisk next(disk_);
    const bool mended = next.mend() == Status::kOk;
    const All now = test::read_all(next);
    bool good = mended;
    bool changed = false;
    for (std::size_t i = 0; i < kDocuments; ++i) {
      good = good && (now[i] == before_[i] || now[i] == after_[i]);
      changed = changed || !(now[i] == before_[i]);
    }
    // What is set aside is nowhere lost.
    const Read& current = now[static_cast<std::size_t>(Document::kSettings)];
    const Read& aside = now[static_cast<std::size_t>(Document::kDamagedSettings)];
    good = good && (current.bytes || aside.bytes || !before_[0].bytes);
    seen_.bad += good ? 0 : 1;
    seen_.fresh += good && changed ? 1 : 0;
    seen_.old += good && !changed ? 1 : 0;
    // Whatever the next cut takes, the other area has everything again.
    if (seen_.points % 64 == 0) {
      for (const std::size_t area : {std::size_t{0}, 2 * kEraseBlockBytes}) {
        Bytes half = disk_.content();
        std::fill_n(half.begin() + static_cast<std::ptrdiff_t>(area), kEraseBlockBytes,
                    std::byte{0});
        Disk other(std::move(half));
        RecordDisk records(other);
        EXPECT_EQ(test::read_all(records), now);
      }
    }
    for (const Disk::Call& call : disk_.log()) {
      touch(call.offset, call.bytes.size());
    }
    for (const auto& [begin, count] : touched_) {
      std::copy_n(base_.begin() + static_cast<std::ptrdiff_t>(begin), count,
                  disk_.content().begin() + static_cast<std::ptrdiff_t>(begin));
    }
    touched_.clear();
  }

  Bytes base_ = test::empty_disk();
  Disk disk_{test::empty_disk()};
  RecordDisk records_{disk_};  // of a sensor that runs all the while
  All before_{};
  All after_{};
  Seen seen_;
  std::vector<std::pair<std::size_t, std::size_t>> touched_;
};

TEST_F(RecordsPowerCut, AtAnyWriteEachDocumentIsTheOldOrTheNewOne) {
  const auto saves = [this](Document document, std::size_t count, std::uint64_t seed) {
    const Bytes bytes = test::bytes_of(count, seed);
    change([&](RecordDisk& disk) { return disk.save(document, bytes); });
  };
  // The first of each, others of other lengths, as a life has them.
  saves(Document::kSettings, 1200, 1);
  saves(Document::kLimits, 300, 2);
  saves(Document::kKeys, 700, 3);
  saves(Document::kCalibration, 20'000, 4);
  saves(Document::kTrial, 10, 5);
  saves(Document::kSettings, 1300, 6);
  saves(Document::kTrial, 10, 7);
  saves(Document::kGoodSettings, 1300, 6);
  saves(Document::kKeys, 900, 8);
  saves(Document::kCalibration, 24'000, 9);
  saves(Document::kSettings, 1100, 10);
  change([](RecordDisk& disk) {
    return disk.set_aside(Document::kSettings, Document::kDamagedSettings);
  });
  saves(Document::kSettings, 1000, 11);
  change([](RecordDisk& disk) {
    return disk.set_aside(Document::kCalibration, Document::kDamagedCalibration);
  });
  EXPECT_EQ(seen_.bad, 0);
  EXPECT_GE(seen_.points, 600);
  EXPECT_GT(seen_.old, 50);
  EXPECT_GT(seen_.fresh, 50);
  std::printf("%d cuts, %d of them with the erase block gone: %d old, %d new\n", seen_.points,
              seen_.erased, seen_.old, seen_.fresh);
}

// A cut took one area; power goes again while the next start writes it anew.
TEST_F(RecordsPowerCut, WhileAnAreaIsWrittenAnewNothingIsLost) {
  {
    RecordDisk records(disk_);
    for (std::size_t i = 0; i < kDocuments; ++i) {
      const Bytes bytes = test::bytes_of(500 + 2000 * i, i);
      ASSERT_EQ(records.save(static_cast<Document>(i), bytes), Status::kOk);
    }
    before_ = test::read_all(records);
  }
  const Bytes whole = disk_.content();
  for (const std::size_t area : {std::size_t{0}, 2 * kEraseBlockBytes}) {
    base_ = whole;
    std::fill_n(base_.begin() + static_cast<std::ptrdiff_t>(area), kEraseBlockBytes,
                std::byte{0xFF});
    disk_.content() = base_;
    change([](RecordDisk& records) { return records.mend(); });
    EXPECT_EQ(disk_.content().size(), whole.size());
    EXPECT_EQ(after_, before_);
  }
  EXPECT_EQ(seen_.bad, 0);
  EXPECT_EQ(seen_.fresh, 0);
  EXPECT_GE(seen_.points, 100);
  std::printf("%d cuts\n", seen_.points);
}

// Of a program that knew no directories: they are written at the first start, then with each save.
TEST_F(RecordsPowerCut, WhileRecordsGetTheirDirectoriesNothingIsLost) {
  {
    RecordDisk records(disk_);
    for (const Document document : {Document::kSettings, Document::kKeys, Document::kLimits}) {
      const Bytes bytes = test::bytes_of(900, number(document));
      ASSERT_EQ(records.save(document, bytes), Status::kOk);
    }
    before_ = test::read_all(records);
  }
  test::forget_directories(disk_.content());
  base_ = disk_.content();
  RecordDisk next(disk_);
  change([&next](RecordDisk&) { return next.mend(); });
  EXPECT_EQ(after_, before_);
  EXPECT_EQ(seen_.bad, 0);
  EXPECT_EQ(seen_.fresh, 0);
  const int mended = seen_.points;
  EXPECT_GT(mended, 0);
  for (std::size_t area = 0; area < kAreas; ++area) {
    EXPECT_FALSE(std::ranges::all_of(test::directory_of(disk_.content(), area),
                                     [](std::byte byte) { return byte == std::byte{0}; }));
  }
  change([&next](RecordDisk&) { return next.save(Document::kKeys, test::bytes_of(800, 77)); });
  EXPECT_EQ(seen_.bad, 0);
  EXPECT_GT(seen_.points, mended);
}

}  // namespace
}  // namespace stof::records
