#include "host/recording/mcap/recover.h"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/dataset/scratch.h"
#include "tests/host/recording/sample_file.h"

namespace stof {
namespace {

using mcap::Buffer;
using test::Samples;

class RecoverTest : public test::Scratch {
 protected:
  std::filesystem::path put_bytes(const std::string& name, const Buffer& bytes) {
    return put(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  static Buffer get(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(stream)), {});
    const mcap::Bytes bytes = mcap::bytes_of(text);
    return {bytes.begin(), bytes.end()};
  }
};

TEST_F(RecoverTest, FileCutAtRandomPointsHasItsIndexAgain) {
  const Samples all = test::samples(600);
  const Buffer file = test::sample_file(all);
  std::mt19937 random(7);  // NOLINT: the same numbers in each run
  for (int cut = 0; cut < 100; ++cut) {
    const std::size_t size = 40 + random() % (file.size() - 40);
    const Buffer before(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
    const test::Streamed streamed = test::stream(before);
    const auto path = put_bytes("cut.mcap", before);
    const auto recovered = mcap::recover(path);
    ASSERT_TRUE(recovered) << size << recovered.error().message;
    EXPECT_FALSE(recovered->was_whole);
    EXPECT_EQ(recovered->messages, streamed.messages.size());
    const Buffer after = get(path);
    EXPECT_EQ(test::by_index(after), streamed.messages) << size;
    const test::Streamed again = test::stream(after);
    EXPECT_EQ(again.messages, streamed.messages) << size;
    EXPECT_EQ(again.end, mcap::StreamReader::End::kWhole) << size;
    EXPECT_EQ(again.metadata, streamed.metadata) << size;
    EXPECT_EQ(again.attachments, streamed.attachments) << size;
  }
}

TEST_F(RecoverTest, WholeFileStaysAsItIs) {
  const Buffer file = test::sample_file(test::samples(50));
  const auto path = put_bytes("whole.mcap", file);
  const auto recovered = mcap::recover(path);
  ASSERT_TRUE(recovered);
  EXPECT_TRUE(recovered->was_whole);
  EXPECT_EQ(get(path), file);
}

// Power is cut at any time: what was flushed is there, of the rest any sectors.
TEST_F(RecoverTest, PowerCutLosesNothingThatWasFlushed) {
  std::mt19937 random(11);  // NOLINT: the same numbers in each run
  const Samples all = test::samples(300);
  for (int trial = 0; trial < 100; ++trial) {
    test::MemorySink disk;
    auto writer = mcap::Writer::begin(disk, {.chunk_bytes = 2048});
    ASSERT_TRUE(writer);
    test::SampleWriter to(*writer);
    const std::size_t flushed = random() % 250;
    const std::size_t written = flushed + random() % 50;
    for (std::size_t k = 0; k < written; ++k) {
      ASSERT_TRUE(to.add(all[k]));
      if (k + 1 == flushed) {
        ASSERT_TRUE(writer->flush());
      }
    }
    Buffer left = disk.file;
    constexpr std::size_t kSector = 512;
    for (std::size_t at = disk.synced; at < left.size(); at += kSector - at % kSector) {
      if (random() % 2 == 0) {
        const std::size_t end = std::min(left.size(), at + kSector - at % kSector);
        std::fill(left.begin() + static_cast<std::ptrdiff_t>(at),
                  left.begin() + static_cast<std::ptrdiff_t>(end), std::byte{0});
      }
    }
    if (random() % 2 == 0) {
      left.resize(disk.synced + random() % (left.size() - disk.synced + 1));
    }
    const auto path = put_bytes("cut.mcap", left);
    auto recovered = mcap::recover(path);
    if (!recovered) {  // a hole before what did reach the disk: into another file
      const auto out = folder() / ("out" + std::to_string(trial));
      recovered = mcap::recover(path, out);
      ASSERT_TRUE(recovered) << recovered.error().message;
      std::filesystem::rename(out, path);
    }
    const std::optional<Samples> found = test::by_index(get(path));
    ASSERT_TRUE(found) << trial;
    ASSERT_GE(found->size(), flushed) << trial;
    for (std::size_t k = 0; k < flushed; ++k) {
      ASSERT_EQ((*found)[k], all[k]) << trial;
    }
  }
}

TEST_F(RecoverTest, DamageInTheMiddleIsRefusedInPlaceAndLeftOutOfACopy) {
  const Samples all = test::samples(200);
  Buffer file = test::sample_file(all);
  const mcap::MemorySource source(file);
  const auto index = mcap::IndexedReader::open(source);
  ASSERT_TRUE(index);
  ASSERT_GT(index->index().chunks.size(), 5U);
  const mcap::ChunkIndex chunk = index->index().chunks[3];
  file[static_cast<std::size_t>(chunk.chunk_offset + chunk.chunk_length - 1)] ^= std::byte{1};
  const auto path = put_bytes("bad.mcap", file);
  const auto refused = mcap::recover(path);
  ASSERT_FALSE(refused);
  test::expect_one_line_about(refused.error().message, path, "give OUT");
  EXPECT_EQ(get(path), file);

  const auto out = folder() / "out.mcap";
  const auto recovered = mcap::recover(path, out);
  ASSERT_TRUE(recovered) << recovered.error().message;
  EXPECT_EQ(recovered->damaged, 1U);
  const std::optional<Samples> found = test::by_index(get(out));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->size(), recovered->messages);
  EXPECT_LT(found->size(), all.size());
  EXPECT_GT(found->size(), all.size() - 20);
  for (const test::Sample& one : *found) {
    EXPECT_EQ(one, all[one.sequence]);
  }
  EXPECT_EQ(get(path), file);
  EXPECT_FALSE(mcap::recover(path, out)) << "a file that is there is not replaced";
}

TEST_F(RecoverTest, WhatIsNoRecordingIsRefused) {
  for (const std::string& bytes :
       {std::string(), std::string("hello"), std::string("\x89MCAP0\r\n")}) {
    const auto path = put("other.mcap", bytes);
    const auto refused = mcap::recover(path);
    ASSERT_FALSE(refused);
    test::expect_one_line_about(refused.error().message, path, "MCAP file");
  }
  EXPECT_FALSE(mcap::recover(folder()));
  EXPECT_FALSE(mcap::recover(folder() / "absent"));
}

// Every size of the disk: what fits is whole, and has an index wherever one fits.
TEST(FullDisk, WhatWasWrittenIsReadable) {
  const Samples all = test::samples(150);
  const std::size_t whole = test::sample_file(all).size();
  int indexed = 0;
  for (std::size_t room = 40; room < whole; room += 37) {
    test::MemorySink disk(room);
    auto writer = mcap::Writer::begin(disk, {.chunk_bytes = 2048});
    if (!writer) {
      continue;
    }
    test::SampleWriter to(*writer);
    std::expected<void, mcap::Problem> done;
    for (std::size_t k = 0; k < all.size() && done; ++k) {
      done = to.add(all[k]);
    }
    if (done) {
      done = writer->finish();
    }
    if (done) {
      continue;  // this file is smaller: it has no attachment
    }
    const std::size_t chunks = writer->index().chunks.size();
    const bool has_index = writer->rescue();
    ASSERT_LE(disk.file.size(), room);
    const test::Streamed streamed = test::stream(disk.file);
    EXPECT_TRUE(test::is_prefix(streamed.messages, all)) << room;
    EXPECT_EQ(streamed.problems, 0U) << room;
    const std::optional<Samples> found = test::by_index(disk.file);
    EXPECT_EQ(found.has_value(), has_index) << room;
    if (found) {
      ++indexed;
      EXPECT_EQ(*found, streamed.messages) << room;
      EXPECT_EQ(streamed.end, mcap::StreamReader::End::kWhole) << room;
      EXPECT_GE(writer->index().chunks.size() + 4, chunks) << "no more is given up than needed";
    } else {
      EXPECT_EQ(streamed.whole_until, disk.file.size()) << room << ": half a record is left";
    }
  }
  EXPECT_GT(indexed, 100);
}

}  // namespace
}  // namespace stof
