#include "firmware/records/record_disk.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "hal/emu/devices/disk.h"
#include "hal/linux/system/file_disk.h"
#include "tests/firmware/records/records_support.h"

namespace stof::records {
namespace {

using hal::emu::Disk;
using test::Bytes;
using test::Read;

constexpr std::size_t kSecondArea = 2 * kEraseBlockBytes;

void erase(Disk& disk, std::size_t area, std::byte value = std::byte{0}) {
  std::fill_n(disk.content().begin() + static_cast<std::ptrdiff_t>(area), kEraseBlockBytes, value);
}

TEST(RecordDisk, GivesWhatWasSavedLast) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  EXPECT_EQ(test::read(records, Document::kKeys), Read{});
  for (std::uint64_t k = 0; k < 5; ++k) {
    const Bytes bytes = test::bytes_of(1000 - 200 * k, k);
    ASSERT_EQ(records.save(Document::kKeys, bytes), Status::kOk);
    EXPECT_EQ(*test::read(records, Document::kKeys).bytes, bytes);
  }
  EXPECT_EQ(test::read(records, Document::kSettings), Read{});
  RecordDisk next(disk);
  EXPECT_EQ(*test::read(next, Document::kKeys).bytes, test::bytes_of(200, 4));
}

TEST(RecordDisk, BothAreasHaveEverythingAndLieFarApart) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  for (std::size_t i = 0; i < kDocuments; ++i) {
    ASSERT_EQ(records.save(static_cast<Document>(i), test::bytes_of(100 + i, i)), Status::kOk);
  }
  const test::All all = test::read_all(records);
  for (const std::size_t area : {std::size_t{0}, kSecondArea}) {
    Disk half(disk.content());
    erase(half, area);
    RecordDisk others(half);
    EXPECT_EQ(test::read_all(others), all);
    ASSERT_EQ(others.mend(), Status::kOk);
    EXPECT_EQ(half.content(), disk.content());
  }
  // Nothing of one area lies within an erase block of the other one, however a card cuts them.
  std::size_t first_end = 0;
  std::size_t second_begin = disk.bytes();
  for (const Disk::Call& call : disk.log()) {
    if (call.offset < kEraseBlockBytes) {
      first_end = std::max(first_end, call.offset + call.bytes.size());
    } else {
      second_begin = std::min(second_begin, call.offset);
    }
  }
  EXPECT_GE(second_begin - first_end, kEraseBlockBytes);
}

TEST(RecordDisk, LostInBothAreasIsNotMissing) {
  Disk disk(test::empty_disk());
  {
    RecordDisk records(disk);
    ASSERT_EQ(records.save(Document::kKeys, test::bytes_of(900, 1)), Status::kOk);
    ASSERT_EQ(records.save(Document::kSettings, test::bytes_of(900, 2)), Status::kOk);
  }
  for (const Disk::Call& call : disk.log()) {
    if (call.bytes == test::bytes_of(900, 1)) {
      disk.content()[call.offset + 3] ^= std::byte{1};
    }
  }
  RecordDisk records(disk);
  EXPECT_NE(records.mend(), Status::kOk);
  EXPECT_TRUE(test::read(records, Document::kKeys).lost);
  EXPECT_TRUE(records.lost(Document::kKeys));
  EXPECT_EQ(*test::read(records, Document::kSettings).bytes, test::bytes_of(900, 2));
  EXPECT_FALSE(records.lost(Document::kSettings));
  // A new one may take its place.
  ASSERT_EQ(records.save(Document::kKeys, test::bytes_of(800, 3)), Status::kOk);
  EXPECT_FALSE(records.lost(Document::kKeys));
  EXPECT_EQ(*test::read(records, Document::kKeys).bytes, test::bytes_of(800, 3));
}

TEST(RecordDisk, WhatIsSetAsideIsKeptAndNotLoaded) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  RecordStore store(records, Document::kSettings, Document::kDamagedSettings);
  ASSERT_EQ(store.save(test::bytes_of(500, 1)), Status::kOk);
  ASSERT_EQ(store.set_aside(), Status::kOk);
  EXPECT_EQ(test::read(records, Document::kSettings), Read{});
  EXPECT_EQ(*test::read(records, Document::kDamagedSettings).bytes, test::bytes_of(500, 1));
  ASSERT_EQ(store.set_aside(), Status::kOk);  // there is none: nothing of what is kept is replaced
  EXPECT_EQ(*test::read(records, Document::kDamagedSettings).bytes, test::bytes_of(500, 1));
  ASSERT_EQ(store.save(test::bytes_of(400, 2)), Status::kOk);
  EXPECT_EQ(*test::read(records, Document::kSettings).bytes, test::bytes_of(400, 2));
}

TEST(RecordDisk, ADocumentWithoutRoomChangesNothing) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  ASSERT_EQ(records.save(Document::kTrial, test::bytes_of(10, 1)), Status::kOk);
  EXPECT_EQ(records.save(Document::kTrial, Bytes(most_bytes(Document::kTrial) + 1)),
            Status::kTooLarge);
  EXPECT_EQ(*test::read(records, Document::kTrial).bytes, test::bytes_of(10, 1));
  std::array<std::byte, 9> small{};
  EXPECT_EQ(records.load(Document::kTrial, small).error(), Status::kTooLarge);
}

// The whole of one area must stand before the other one is touched.
TEST(RecordDisk, AMediumThatTakesNoMoreKeepsWhatItHas) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  ASSERT_EQ(records.save(Document::kSettings, test::bytes_of(900, 1)), Status::kOk);
  for (const int writes : {0, 1}) {
    disk.breaks_after = writes;
    EXPECT_EQ(records.save(Document::kSettings, test::bytes_of(950, 2)), Status::kDeviceError);
    EXPECT_EQ(*test::read(records, Document::kSettings).bytes, test::bytes_of(900, 1));
  }
  // The second area takes none: it is saved, and from then on nothing is risked.
  disk.breaks_after = -1;
  ASSERT_EQ(records.mend(), Status::kOk);
  disk.breaks_after = 2;
  EXPECT_EQ(records.save(Document::kSettings, test::bytes_of(950, 3)), Status::kOk);
  EXPECT_EQ(records.save(Document::kSettings, test::bytes_of(950, 4)), Status::kDeviceError);
  EXPECT_EQ(records.save(Document::kKeys, test::bytes_of(950, 5)), Status::kDeviceError);
  EXPECT_EQ(*test::read(records, Document::kSettings).bytes, test::bytes_of(950, 3));
}

TEST(RecordDisk, AnAreaThatCannotBeReadIsReplacedByTheOther) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  ASSERT_EQ(records.save(Document::kSettings, test::bytes_of(900, 1)), Status::kOk);
  disk.unreadable_end = kEraseBlockBytes;
  EXPECT_EQ(*test::read(records, Document::kSettings).bytes, test::bytes_of(900, 1));
}

TEST(RecordDisk, LivesInAFileOfLinux) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "records_disk";
  std::filesystem::remove(file);
  EXPECT_EQ(hal::linux::FileDisk::open(file).error(), Status::kDeviceError);
  EXPECT_EQ(hal::linux::FileDisk::open(testing::TempDir()).error(), Status::kUnsupported);
  std::ofstream(file).close();
  std::filesystem::resize_file(file, kRecordsBytes);
  for (std::uint64_t k = 0; k < 3; ++k) {
    const auto disk = hal::linux::FileDisk::open(file);
    ASSERT_TRUE(disk);
    EXPECT_EQ((*disk)->bytes(), kRecordsBytes);
    EXPECT_EQ((*disk)->write(kRecordsBytes - 1, Bytes(2)), Status::kInvalidArgument);
    RecordDisk records(**disk);
    EXPECT_EQ(records.mend(), Status::kOk);
    EXPECT_EQ(test::read(records, Document::kKeys).bytes,
              k == 0 ? std::nullopt : std::optional(test::bytes_of(90, k - 1)));
    EXPECT_EQ(records.save(Document::kKeys, test::bytes_of(90, k)), Status::kOk);
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace stof::records
