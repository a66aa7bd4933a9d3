// What bad flash, a torn copy or another size of the disk does to what is kept: a document is as it
// was, or lost. It is never as if it had never been there: that would open a sensor that has keys.
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "hal/emu/devices/disk.h"
#include "tests/firmware/records/records_support.h"

namespace stof::records {
namespace {

using hal::emu::Disk;
using test::All;
using test::Bytes;
using test::Read;

constexpr std::size_t kPage = std::size_t{64} << 10;  // of each document here, with its bytes

// Disks as they were after the third and after the second save of each document.
struct Kept {
  explicit Kept(std::size_t bytes = kRecordsBytes) : now(bytes) {
    Disk disk(now);
    RecordDisk records(disk);
    for (std::uint64_t k = 0; k < 3; ++k) {
      older = disk.content();
      for (std::size_t i = 0; i < kDocuments; ++i) {
        const Bytes text = test::bytes_of(600 + 10 * i, 100 * k + i);
        EXPECT_EQ(records.save(static_cast<Document>(i), text), Status::kOk);
      }
    }
    now = disk.content();
    all = test::read_all(records);
  }

  Bytes now;
  Bytes older;
  All all{};
};

const Kept& kept() {
  static const Kept all_of_it;
  return all_of_it;
}

constexpr Read kLost{.bytes = {}, .lost = true};

// What one area's page may become.
struct Damage {
  const char* name;
  std::function<void(Bytes& content, std::size_t begin, std::size_t count)> to;
};

void zero(Bytes& content, std::size_t begin, std::size_t count) {
  std::ranges::fill(test::at(content, begin, count), std::byte{0});
}
void set_ones(Bytes& content, std::size_t begin, std::size_t count) {
  std::ranges::fill(test::at(content, begin, count), std::byte{0xFF});
}
void flip(Bytes& content, std::size_t begin, std::size_t) { content[begin + 17] ^= std::byte{4}; }
void flip_end(Bytes& content, std::size_t begin, std::size_t) {
  content[begin + kHeadBytes + 599] ^= std::byte{1};
}
void bring_back(Bytes& content, std::size_t begin, std::size_t count) {
  std::ranges::copy(std::span(kept().older).subspan(begin, count),
                    test::at(content, begin, count).begin());
}

// Of both areas' directories.
struct Marks {
  const char* name;
  std::function<void(Bytes& content)> to;
  bool known = true;  // how new each document is can still be known
};

void damage_directory(Bytes& content, std::size_t area, const Damage& damage) {
  const std::size_t begin = test::area_of(content, area) + kDirectoryPlace;
  damage.to(content, begin, kHeadBytes);
}

const std::vector<Marks>& marks() {
  static const std::vector<Marks> all_marks{
      {"whole", [](Bytes&) {}},
      {"zeros in one", [](Bytes& content) { damage_directory(content, 0, {"", zero}); }},
      {"flipped in the other", [](Bytes& content) { damage_directory(content, 1, {"", flip}); }},
      {"older in one", [](Bytes& content) { damage_directory(content, 0, {"", bring_back}); }},
      {"zeros in both",
       [](Bytes& content) {
         damage_directory(content, 0, {"", zero});
         damage_directory(content, 1, {"", zero});
       },
       false},
      {"flipped in both",
       [](Bytes& content) {
         damage_directory(content, 0, {"", flip});
         damage_directory(content, 1, {"", flip});
       },
       false}};
  return all_marks;
}

// Starts twice, pairs anew, and looks again.
void expect_of(Disk& disk, const All& expected, const std::string& what) {
  const bool lost = std::ranges::find(expected, kLost) != expected.end();
  for (int start = 0; start < 2; ++start) {
    RecordDisk records(disk);
    EXPECT_EQ(records.mend() == Status::kOk, !lost) << what;
    EXPECT_TRUE(test::read_all(records) == expected) << what << ", start " << start;
  }
  const Bytes anew = test::bytes_of(700, 9);
  {
    RecordDisk records(disk);
    ASSERT_EQ(records.save(Document::kKeys, anew), Status::kOk) << what;
  }
  RecordDisk records(disk);
  EXPECT_EQ(test::read(records, Document::kKeys), Read{.bytes = anew}) << what;
}

// All that is kept, as it was.
void restore(Bytes& content) {
  const auto copy = [&content](std::size_t begin, std::size_t count) {
    std::ranges::copy(std::span(kept().now).subspan(begin, count),
                      test::at(content, begin, count).begin());
  };
  for (std::size_t area = 0; area < kAreas; ++area) {
    for (std::size_t i = 0; i < kDocuments; ++i) {
      copy(test::place_of(content, area, static_cast<Document>(i)), kPage);
    }
    copy(test::area_of(content, area) + kDirectoryPlace, kHeadBytes);
  }
}

TEST(RecordsDamage, WhatWasThereIsNeverAsIfItHadNeverBeen) {
  const std::vector<Damage> damages{{"zeros", zero},
                                    {"ones", set_ones},
                                    {"a bit of the head", flip},
                                    {"a bit of the bytes", flip_end},
                                    {"an older copy", bring_back}};
  Disk disk(kept().now);
  for (const Document document : {Document::kKeys, Document::kLimits, Document::kCalibration}) {
    for (const Damage& damage : damages) {
      for (const auto& [first, last] : {std::pair(0U, 0U), std::pair(1U, 1U), std::pair(0U, 1U)}) {
        for (const Marks& mark : marks()) {
          Bytes& content = disk.content();
          restore(content);
          for (std::size_t area = first; area <= last; ++area) {
            damage.to(content, test::place_of(content, area, document), kPage);
          }
          mark.to(content);
          All expected = kept().all;
          if (first != last) {
            expected[number(document)] = kLost;
          }
          // Nobody knows any more that it is older: it is read, and is no open sensor either.
          if (first != last && !mark.known && damage.name == std::string("an older copy")) {
            expected[number(document)].bytes =
                test::bytes_of(600 + 10 * number(document), 100 + number(document));
            expected[number(document)].lost = false;
          }
          expect_of(disk, expected,
                    std::to_string(number(document)) + " " + damage.name + " from area " +
                        std::to_string(first) + " to " + std::to_string(last) + ", directory " +
                        mark.name);
        }
      }
    }
  }
}

TEST(RecordsDamage, PagesAndAreasThatChangePlacesAreNoOthers) {
  const auto swap = [](Bytes& content, std::size_t a, std::size_t b, std::size_t count) {
    std::ranges::swap_ranges(test::at(content, a, count), test::at(content, b, count));
  };
  Bytes content = kept().now;
  All expected = kept().all;
  for (std::size_t area = 0; area < kAreas; ++area) {
    swap(content, test::place_of(content, area, Document::kKeys),
         test::place_of(content, area, Document::kSettings), kPage);
  }
  expected[number(Document::kKeys)] = kLost;
  expected[number(Document::kSettings)] = kLost;
  Disk swapped(content);
  expect_of(swapped, expected, "keys in the settings' place");

  content = kept().now;
  swap(content, 0, kBetweenAreas, kEraseBlockBytes);
  Disk exchanged(content);
  expect_of(exchanged, kept().all, "one area in the other's place");
}

// What was written before all is zeros is gone: nothing tells that from a disk that is new.
TEST(RecordsDamage, ADiskOfZerosIsANewOne) {
  Disk disk(test::empty_disk());
  RecordDisk records(disk);
  EXPECT_FALSE(records.found());
  EXPECT_EQ(records.mend(), Status::kOk);
  EXPECT_EQ(test::read_all(records), All{});
  RecordDisk next(disk);
  EXPECT_TRUE(next.found());
  EXPECT_EQ(test::read_all(next), All{});
}

TEST(RecordsDamage, ALargerDiskHasEverythingWhereItWas) {
  for (const std::size_t size : {kRecordsBytes, kRecordsBytes + 100'100}) {
    const Kept kept_there(size);
    for (const bool listed : {true, false}) {
      for (const std::size_t more :
           {std::size_t{1}, kPage, kEraseBlockBytes, kBetweenAreas, kRecordsBytes}) {
        Bytes content = kept_there.now;
        if (!listed) {
          test::forget_directories(content);
        }
        content.resize(size + more);
        Disk disk(std::move(content));
        // Without directories, the second area may be taken for the first one of a larger disk.
        EXPECT_EQ(RecordDisk(disk).moved(), listed || more != kBetweenAreas) << more;
        EXPECT_FALSE(RecordDisk(disk).cut_off());
        expect_of(disk, kept_there.all,
                  std::to_string(more) + " more than " + std::to_string(size));
      }
    }
  }
}

TEST(RecordsDamage, ASmallerDiskIsReadAndNotWritten) {
  for (const bool listed : {true, false}) {
    for (const std::size_t less :
         {std::size_t{3585}, kPage, kEraseBlockBytes, kBetweenAreas - 1, kBetweenAreas}) {
      for (const std::size_t in_front : {std::size_t{0}, 2 * kRecordsBytes}) {
        if (!listed && in_front > 0 && less == kBetweenAreas) {
          continue;  // the first area lies where the second one of that disk does, and is taken for
                     // it
        }
        Bytes content(in_front + kRecordsBytes - less);
        std::copy_n(kept().now.begin(), kRecordsBytes - less,
                    content.begin() + static_cast<std::ptrdiff_t>(in_front));
        if (!listed) {
          Bytes before = kept().now;
          test::forget_directories(before);
          std::copy_n(before.begin(), kRecordsBytes - less,
                      content.begin() + static_cast<std::ptrdiff_t>(in_front));
        }
        Disk disk(std::move(content));
        RecordDisk records(disk);
        EXPECT_TRUE(records.found() && records.cut_off()) << less;
        EXPECT_EQ(records.mend(), Status::kDeviceError);
        EXPECT_TRUE(test::read_all(records) == kept().all) << less;
        EXPECT_EQ(records.save(Document::kKeys, test::bytes_of(700, 9)), Status::kDeviceError);
        RecordDisk next(disk);
        EXPECT_TRUE(test::read_all(next) == kept().all) << less;
      }
    }
  }
  // Of the first area, too: what is left is read, the rest is lost.
  for (const Document until : {Document::kCalibration, Document::kKeys}) {
    Bytes content = kept().now;
    content.resize(kPlaces[number(until)]);
    Disk disk(std::move(content));
    RecordDisk records(disk);
    EXPECT_TRUE(records.found() && records.cut_off());
    EXPECT_EQ(records.mend(), Status::kDeviceError);
    for (const Document document :
         {Document::kSettings, Document::kLimits, Document::kKeys, Document::kCalibration}) {
      EXPECT_EQ(test::read(records, document),
                number(document) < number(until) ? kept().all[number(document)] : kLost);
    }
  }
}

}  // namespace
}  // namespace stof::records
