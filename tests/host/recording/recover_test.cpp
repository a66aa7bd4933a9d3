#include "host/recording/mcap/recover.h"

#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include "host/recording/mcap/crc32.h"
#include "host/recording/mcap/record_bytes.h"
#include "host/recording/mcap/zstd.h"
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

// Heads of the records between the header and the data end.
struct HeadAt {
  std::size_t at = 0;
  mcap::Opcode opcode{};
};
std::vector<HeadAt> data_heads(const Buffer& file) {
  std::vector<HeadAt> heads;
  for (std::size_t at = mcap::kMagic.size(); at + mcap::kRecordHead < file.size();) {
    std::uint64_t length = 0;
    std::memcpy(&length, file.data() + at + 1, sizeof length);
    const auto opcode = static_cast<mcap::Opcode>(file[at]);
    if (opcode == mcap::Opcode::kDataEnd) {
      break;
    }
    if (opcode != mcap::Opcode::kHeader) {
      heads.push_back({.at = at, .opcode = opcode});
    }
    at += mcap::kRecordHead + static_cast<std::size_t>(length);
  }
  return heads;
}

bool is_definition(mcap::Opcode opcode) {
  return opcode == mcap::Opcode::kSchema || opcode == mcap::Opcode::kChannel;
}

std::size_t lost_of(const Samples& all, const Samples& found) {
  EXPECT_TRUE(std::ranges::all_of(
      found, [&](const test::Sample& one) { return one == all[one.sequence]; }));
  return all.size() - found.size();
}

Buffer with_flipped_bit(Buffer file, std::size_t at, unsigned bit) {
  file[at + bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
  return file;
}

constexpr unsigned kHeadBits = 8 * mcap::kRecordHead;
constexpr std::size_t kMostInAChunk = 25;

// Whatever one bit of a record's head says instead, no other record is lost, and the loss is told.
TEST(McapDamage, FlippedBitOfARecordHeadCostsThatRecordAlone) {
  const Samples all = test::samples(50);
  const Buffer file = test::sample_file(all);
  for (const HeadAt& head : data_heads(file)) {
    for (unsigned bit = 0; bit < kHeadBits; ++bit) {
      const test::Streamed streamed = test::stream(with_flipped_bit(file, head.at, bit));
      if (is_definition(head.opcode)) {
        EXPECT_GT(streamed.problems, 0U) << head.at << " bit " << bit;
        continue;  // what is of it is lost with it
      }
      const std::size_t lost = lost_of(all, streamed.messages);
      EXPECT_LE(lost, head.opcode == mcap::Opcode::kChunk ? kMostInAChunk : 0)
          << head.at << " bit " << bit;
      const bool all_there = lost == 0 && streamed.attachments == 1 && streamed.metadata == 1;
      EXPECT_TRUE(all_there || streamed.problems > 0) << head.at << " bit " << bit;
    }
  }
}

TEST_F(RecoverTest, FlippedBitOfARecordHeadIsNotRepairedByCuttingWhatFollows) {
  const Samples all = test::samples(50);
  const Buffer file = test::sample_file(all);
  const std::vector<HeadAt> heads = data_heads(file);
  ASSERT_GT(heads.size(), 12U);
  std::size_t last_chunk = 0;
  for (const HeadAt& head : heads) {
    last_chunk = head.opcode == mcap::Opcode::kChunk ? head.at : last_chunk;
  }
  for (const HeadAt& head : heads) {
    for (const unsigned bit : {0U, 3U, 4U, 8U, 14U, 40U}) {
      if (head.at >= last_chunk) {
        continue;  // a tail: it may be cut
      }
      const Buffer bad = with_flipped_bit(file, head.at, bit);
      const auto path = put_bytes("bad.mcap", bad);
      const auto recovered = mcap::recover(path);
      if (!recovered) {
        test::expect_one_line_about(recovered.error().message, path, "give OUT");
        EXPECT_EQ(get(path), bad) << head.at << " bit " << bit;
      } else {
        const std::optional<Samples> found = test::by_index(get(path));
        ASSERT_TRUE(found) << head.at << " bit " << bit;
        EXPECT_EQ(found->size(), all.size()) << head.at << " bit " << bit;
      }
    }
  }
}

TEST_F(RecoverTest, ZeroedSectorIsNotRepairedByCuttingWhatFollows) {
  const Samples all = test::samples(100);
  const Buffer file = test::sample_file(all);
  constexpr std::size_t kSector = 512;
  for (std::size_t at = kSector; at < file.size() / 2; at += kSector) {
    Buffer bad = file;
    std::fill_n(bad.begin() + static_cast<std::ptrdiff_t>(at), kSector, std::byte{0});
    const test::Streamed streamed = test::stream(bad);
    EXPECT_GT(streamed.problems, 0U) << at;
    if (at > 2 * kSector) {  // behind the definitions
      EXPECT_LE(lost_of(all, streamed.messages), 2 * kMostInAChunk) << at;
    }
    const auto path = put_bytes("bad.mcap", bad);
    EXPECT_FALSE(mcap::recover(path)) << at;
    EXPECT_EQ(get(path), bad) << at;
  }
}

// Ids of the second file mean other channels than those of the first.
TEST_F(RecoverTest, TwoFilesOneBehindTheOtherAreReadAndNotCut) {
  const Samples first = test::samples(40);
  Samples second = test::samples(42);
  second.erase(second.begin(), second.begin() + 2);  // begins with /other
  ASSERT_NE(first.front().topic, second.front().topic);
  Buffer both = test::sample_file(first);
  const Buffer behind = test::sample_file(second);
  const std::size_t size = both.size();
  mcap::append_bytes(both, behind);
  Samples all = first;
  all.insert(all.end(), second.begin(), second.end());
  const test::Streamed streamed = test::stream(both);
  EXPECT_EQ(streamed.messages, all);
  EXPECT_EQ(streamed.problems, 1U);
  EXPECT_EQ(streamed.attachments, 2U);
  const auto path = put_bytes("both.mcap", both);
  const auto refused = mcap::recover(path);
  ASSERT_FALSE(refused);
  test::expect_one_line_about(refused.error().message, path, std::to_string(size));
  EXPECT_EQ(get(path), both);
  const auto out = folder() / "out.mcap";
  const auto recovered = mcap::recover(path, out);
  ASSERT_TRUE(recovered) << recovered.error().message;
  EXPECT_EQ(recovered->files, 2U);
  EXPECT_EQ(test::stream(get(out)).messages, all);
}

TEST_F(RecoverTest, IndexThatNamesWhatIsNotThereIsTold) {
  const Buffer file = test::sample_file(test::samples(50));
  const mcap::MemorySource source(file);
  const auto reader = mcap::IndexedReader::open(source);
  ASSERT_TRUE(reader);
  mcap::FileIndex index = reader->index();
  index.chunks.front().chunk_offset += 3;
  Buffer bad = file;
  bad.resize(static_cast<std::size_t>(test::stream(file).whole_until));
  append_summary(bad, index, bad.size(), 0);
  EXPECT_EQ(test::stream(bad).problems, 1U);
  const auto path = put_bytes("bad.mcap", bad);
  const auto refused = mcap::recover(path);
  ASSERT_FALSE(refused);
  test::expect_one_line_about(refused.error().message, path, "give OUT");
  EXPECT_EQ(get(path), bad);
}

TEST_F(RecoverTest, ChunksThatAnotherReaderCanReadAreNotCut) {
  Buffer file = test::sample_file(test::samples(5));
  file.resize(static_cast<std::size_t>(test::stream(file).whole_until));
  append(file, mcap::Chunk{
                   .uncompressed_size = 3, .compression = "lz4", .records = mcap::bytes_of("abc")});
  const auto path = put_bytes("lz4.mcap", file);
  const auto refused = mcap::recover(path);
  ASSERT_FALSE(refused);
  test::expect_one_line_about(refused.error().message, path, "compression is not known");
  EXPECT_EQ(get(path), file);
}

TEST_F(RecoverTest, FileThatIsBeingWrittenIsRefused) {
  const Buffer file = test::sample_file(test::samples(20));
  const auto path = put_bytes("live.mcap", Buffer(file.begin(), file.end() - 20));
  const std::size_t size = get(path).size();
  {
    auto source = mcap::FileSource::open(path);
    ASSERT_TRUE(source);
    ASSERT_TRUE(source->lock(path));
    const auto second = mcap::FileSink::open(path, mcap::FileSink::Existing::kReplace);
    ASSERT_FALSE(second);
    test::expect_one_line_about(second.error().message, path, "being written");
    const auto refused = mcap::recover(path);
    ASSERT_FALSE(refused);
    test::expect_one_line_about(refused.error().message, path, "being written");
    EXPECT_EQ(get(path).size(), size);
  }
  {
    const auto sink =
        mcap::FileSink::open(folder() / "new.mcap", mcap::FileSink::Existing::kRefuse);
    ASSERT_TRUE(sink);
    EXPECT_FALSE(mcap::FileSink::open(folder() / "new.mcap", mcap::FileSink::Existing::kReplace));
  }
  EXPECT_TRUE(mcap::FileSink::open(folder() / "new.mcap", mcap::FileSink::Existing::kReplace));
  EXPECT_TRUE(mcap::recover(path));
}

TEST_F(RecoverTest, LinksAreNotWrittenThrough) {
  const auto path = put("target", "kept");
  std::filesystem::create_symlink(path, folder() / "link.mcap");
  std::filesystem::create_symlink(folder() / "absent", folder() / "dangling.mcap");
  using Existing = mcap::FileSink::Existing;
  for (const char* const name : {"link.mcap", "dangling.mcap"}) {
    for (const Existing existing : {Existing::kRefuse, Existing::kReplace}) {
      const auto sink = mcap::FileSink::open(folder() / name, existing);
      ASSERT_FALSE(sink) << name;
      EXPECT_EQ(std::ranges::count(sink.error().message, '\n'), 0);
    }
  }
  EXPECT_EQ(get(path).size(), 4U);
  EXPECT_FALSE(std::filesystem::exists(folder() / "absent"));
}

TEST_F(RecoverTest, OutIsReplacedOnlyWhereThatIsAskedForAndIsNeverTheFileItself) {
  const Samples all = test::samples(20);
  const Buffer file = test::sample_file(all);
  const auto path = put_bytes("whole.mcap", file);
  const auto out = put("out.mcap", "old");
  std::filesystem::create_hard_link(path, folder() / "same.mcap");
  constexpr auto kReplace = mcap::FileSink::Existing::kReplace;
  EXPECT_FALSE(mcap::recover(path, out));
  EXPECT_FALSE(mcap::recover(path, folder() / "same.mcap", kReplace));
  EXPECT_EQ(get(path), file);
  ASSERT_TRUE(mcap::recover(path, out, kReplace));
  EXPECT_EQ(test::stream(get(out)).messages, all);
}

// 22 kB of zstd that say half a million messages, or 256 MiB of nothing.
TEST_F(RecoverTest, LittleBytesDoNotBecomeMany) {
  Buffer records;
  append(records, mcap::Channel{.id = 1, .topic = "/a", .message_encoding = "cdr"});
  while (records.size() < 4U << 20U) {
    append(records, mcap::Message{.channel_id = 1});
  }
  mcap::ZstdCompressor compressor(1);
  const auto file_of = [&](const Buffer& content) {
    Buffer packed;
    compressor.compress(content, packed);
    Buffer file;
    mcap::append_bytes(file, std::as_bytes(std::span(mcap::kMagic)));
    append(file, mcap::Header{});
    append(file, mcap::Chunk{.uncompressed_size = content.size(),
                             .uncompressed_crc = mcap::crc32(content),
                             .compression = "zstd",
                             .records = packed});
    return file;
  };
  for (const Buffer& content : {records, Buffer(std::size_t{17} << 20)}) {
    const Buffer file = file_of(content);
    const auto path = put_bytes("bomb.mcap", file);
    EXPECT_EQ(test::stream(file).problems, 1U);
    EXPECT_FALSE(mcap::recover(path)) << "nothing of it is damaged";
    EXPECT_EQ(get(path), file);
    const auto out = folder() / "out.mcap";
    const auto recovered = mcap::recover(path, out, mcap::FileSink::Existing::kReplace);
    ASSERT_TRUE(recovered);
    EXPECT_EQ(recovered->damaged, 1U);
    EXPECT_LT(std::filesystem::file_size(out), file.size() + 1000);
  }
}

// Many small chunks of 8 MiB each: what reading takes stays in proportion to the file.
TEST_F(RecoverTest, ManyLittleChunksDoNotBecomeMany) {
  constexpr std::size_t kContent = std::size_t{8} << 20;
  Buffer content;
  append(content, mcap::Metadata{.name = std::string(kContent, 'a')});
  Buffer packed;
  mcap::ZstdCompressor(19).compress(content, packed);
  Buffer file;
  mcap::append_bytes(file, std::as_bytes(std::span(mcap::kMagic)));
  append(file, mcap::Header{});
  constexpr std::size_t kChunks = 100;
  for (std::size_t k = 0; k < kChunks; ++k) {
    append(file, mcap::Chunk{.uncompressed_size = content.size(),
                             .uncompressed_crc = mcap::crc32(content),
                             .compression = "zstd",
                             .records = packed});
  }
  const std::size_t may = (mcap::most_unpacked(file.size()) / content.size()) + 1;
  ASSERT_LT(may, kChunks);
  EXPECT_GE(test::stream(file).problems, kChunks - may);
  EXPECT_FALSE(mcap::recover(put_bytes("bomb.mcap", file))) << "nothing of it is damaged";
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
