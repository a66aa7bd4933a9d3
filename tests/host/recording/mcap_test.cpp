#include <gtest/gtest.h>

#include "host/recording/mcap/chunk.h"
#include "host/recording/mcap/crc32.h"
#include "host/recording/mcap/record_bytes.h"
#include "tests/host/recording/sample_file.h"

namespace stof {
namespace {

using mcap::Buffer;
using mcap::Bytes;
using mcap::Opcode;
using test::Samples;

TEST(Crc32, KnownAnswer) {
  EXPECT_EQ(mcap::crc32(mcap::bytes_of("123456789")), 0xCBF43926U);
  EXPECT_EQ(mcap::crc32({}), 0U);
}

TEST(Crc32, PiecesGiveTheSameAsTheWhole) {
  const std::string text(100, 'q');
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    mcap::Crc32 crc;
    crc.add(mcap::bytes_of(text.substr(0, cut)));
    crc.add(mcap::bytes_of(text.substr(cut)));
    ASSERT_EQ(crc.value(), mcap::crc32(mcap::bytes_of(text))) << cut;
  }
}

TEST(McapRecord, BytesAreThoseOfTheSpecification) {
  Buffer bytes;
  append(bytes, mcap::Channel{.id = 2,
                              .schema_id = 1,
                              .topic = "/t",
                              .message_encoding = "cdr",
                              .metadata = {{"k", "v"}}});
  const std::array<std::uint8_t, 40> expected{
      0x04, 31, 0, 0, 0,   0,   0,   0, 0,  // opcode, length
      2,    0,  1, 0,                       // ids
      2,    0,  0, 0, '/', 't',             // topic
      3,    0,  0, 0, 'c', 'd', 'r',        // message encoding
      10,   0,  0, 0,                       // metadata: bytes
      1,    0,  0, 0, 'k', 1,   0,   0, 0, 'v'};
  EXPECT_TRUE(std::ranges::equal(bytes, std::as_bytes(std::span(expected))));
}

TEST(McapFile, EveryMessageComesBackByStreamAndByIndex) {
  for (const std::size_t count : {0U, 1U, 2U, 200U}) {
    const Samples all = test::samples(count);
    const Buffer file = test::sample_file(all);
    const test::Streamed streamed = test::stream(file);
    EXPECT_EQ(streamed.messages, all);
    EXPECT_EQ(streamed.end, mcap::StreamReader::End::kWhole);
    EXPECT_EQ(streamed.metadata, 1U);
    EXPECT_EQ(streamed.attachments, count == 0 ? 0U : 1U);
    EXPECT_EQ(streamed.problems, 0U);
    EXPECT_EQ(test::by_index(file), all);
  }
}

TEST(McapFile, IndexedReaderReadsOnlyWhatIsChosen) {
  const Samples all = test::samples(100);
  const std::optional<Samples> other = test::by_index(test::sample_file(all), "/other");
  ASSERT_TRUE(other);
  EXPECT_EQ(other->size(), 33U);
  for (const test::Sample& one : *other) {
    EXPECT_EQ(one.topic, "/other");
    EXPECT_EQ(one, all[one.sequence]);
  }
}

TEST(McapFile, IndexHasStatisticsAttachmentsAndMetadata) {
  const Samples all = test::samples(100);
  const Buffer file = test::sample_file(all);
  const mcap::MemorySource source(file);
  auto reader = mcap::IndexedReader::open(source);
  ASSERT_TRUE(reader);
  const mcap::Statistics& statistics = reader->index().statistics;
  EXPECT_EQ(statistics.message_count, 100U);
  EXPECT_EQ(statistics.schema_count, 1U);
  EXPECT_EQ(statistics.channel_count, 2U);
  EXPECT_EQ(statistics.chunk_count, reader->index().chunks.size());
  EXPECT_GT(statistics.chunk_count, 3U);
  const auto [first, last] = std::ranges::minmax(all, {}, &test::Sample::log_time);
  EXPECT_EQ(statistics.start_time, first.log_time);
  EXPECT_EQ(statistics.end_time, last.log_time);
  ASSERT_EQ(reader->index().attachments.size(), 1U);
  const auto attachment = reader->attachment(reader->index().attachments.front());
  ASSERT_TRUE(attachment);
  EXPECT_EQ(attachment->name, "settings.json");
  EXPECT_TRUE(std::ranges::equal(attachment->data, mcap::bytes_of("{}")));
  ASSERT_EQ(reader->index().metadata.size(), 1U);
  const auto metadata = reader->metadata(reader->index().metadata.front());
  ASSERT_TRUE(metadata);
  EXPECT_EQ(metadata->entries, (mcap::TextMap{{"a", "b"}, {"c", ""}}));
}

// Any flipped bit: what is delivered is what was written, or nothing.
TEST(McapFile, DamagedBytesAreNeverDelivered) {
  const Samples all = test::samples(30);
  const Buffer file = test::sample_file(all);
  for (std::size_t at = 0; at < file.size(); ++at) {
    Buffer bad = file;
    bad[at] ^= std::byte{static_cast<unsigned char>(1U << at % 8)};
    const test::Streamed streamed = test::stream(bad);
    // A topic's name, or a channel's number, lies outside of chunks and has no CRC.
    for (const test::Sample& one : streamed.messages) {
      ASSERT_LT(one.sequence, all.size()) << at;
      ASSERT_EQ(one.data, all[one.sequence].data) << at;
      ASSERT_EQ(one.log_time, all[one.sequence].log_time) << at;
    }
  }
}

TEST(McapFile, EveryCutIsReadUpToItsLastWholeChunk) {
  const Samples all = test::samples(40);
  const Buffer file = test::sample_file(all);
  std::size_t before = 0;
  for (std::size_t size = 0; size < file.size(); ++size) {
    const Buffer cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
    const test::Streamed streamed = test::stream(cut);
    ASSERT_TRUE(test::is_prefix(streamed.messages, all)) << size;
    ASSERT_GE(streamed.messages.size(), before) << size;
    ASSERT_NE(streamed.end, mcap::StreamReader::End::kWhole) << size;
    ASSERT_FALSE(mcap::IndexedReader::open(mcap::MemorySource(cut))) << size;
    before = streamed.messages.size();
  }
  EXPECT_EQ(before, all.size());
}

class HostileFile : public testing::Test {
 protected:
  HostileFile() {
    mcap::append_bytes(file_, std::as_bytes(std::span(mcap::kMagic)));
    append(file_, mcap::Header{});
  }
  // The only problem of the file, or what else came of it.
  std::string problem(const mcap::Limits& limits = {}) {
    const mcap::MemorySource source(file_);
    auto reader = mcap::StreamReader::open(source, limits);
    if (!reader) {
      return reader.error().message;
    }
    const auto item = reader->next();
    return item ? (*item ? "an item" : "the end") : item.error().message;
  }
  Buffer file_;
};

TEST_F(HostileFile, ChunkThatClaimsMoreThanItCanHoldAsksForNoMemory) {
  append(file_, mcap::Chunk{.uncompressed_size = std::uint64_t{1} << 60,
                            .compression = "zstd",
                            .records = mcap::bytes_of("abc")});
  EXPECT_NE(problem().find("more than any chunk"), std::string::npos) << problem();
}

TEST_F(HostileFile, SmallChunkThatClaimsALargeOneAsksForNoMemory) {
  append(file_, mcap::Chunk{.uncompressed_size = std::uint64_t{200} << 20,
                            .compression = "zstd",
                            .records = mcap::bytes_of("abc")});
  EXPECT_NE(problem().find("more than it can"), std::string::npos) << problem();
}

TEST_F(HostileFile, ChunkOfUnknownCompressionIsSaidSo) {
  append(
      file_,
      mcap::Chunk{.uncompressed_size = 3, .compression = "lz4", .records = mcap::bytes_of("abc")});
  EXPECT_NE(problem().find("compression is not known"), std::string::npos) << problem();
}

TEST_F(HostileFile, StoredChunkWhoseLengthsContradictIsRefused) {
  append(file_, mcap::Chunk{.uncompressed_size = 4, .records = mcap::bytes_of("abc")});
  EXPECT_NE(problem().find("contradict"), std::string::npos) << problem();
}

TEST_F(HostileFile, ChunkInAChunkIsNotOpened) {
  Buffer inner;
  append(inner, mcap::Chunk{.uncompressed_size = std::uint64_t{1} << 60, .compression = "zstd"});
  append(file_, mcap::Chunk{.uncompressed_size = inner.size(), .records = inner});
  EXPECT_EQ(problem(), "the end");
}

TEST_F(HostileFile, MessageOfAChannelThatIsNotThereIsRefused) {
  Buffer inner;
  append(inner, mcap::Message{.channel_id = 9});
  append(file_, mcap::Chunk{.uncompressed_size = inner.size(), .records = inner});
  EXPECT_NE(problem().find("channel that is not there"), std::string::npos) << problem();
}

TEST_F(HostileFile, ChannelsBeyondTheLimitAreRefused) {
  append(file_, mcap::Channel{.id = 1});
  append(file_, mcap::Channel{.id = 2});
  EXPECT_NE(problem({.channels = 1}).find("too many"), std::string::npos);
  EXPECT_EQ(problem({.channels = 2}), "the end");
}

TEST_F(HostileFile, RecordLongerThanTheFileIsACut) {
  mcap::append(file_, std::uint8_t{0x06});
  mcap::append(file_, ~std::uint64_t{0});
  EXPECT_EQ(problem(), "the end");
  EXPECT_EQ(test::stream(file_).end, mcap::StreamReader::End::kCut);
}

TEST_F(HostileFile, OtherFilesAreSaidToBeNone) {
  file_.front() = std::byte{'x'};
  EXPECT_EQ(problem(), "is not an MCAP file: give a recording");
  file_.clear();
  EXPECT_EQ(problem(), "is not an MCAP file: give a recording");
}

// What an index names may be anything.
TEST(HostileIndex, OffsetsThatLeadNowhereAreProblems) {
  const Samples all = test::samples(5);
  const Buffer file = test::sample_file(all);
  const mcap::MemorySource whole_source(file);
  auto reader = mcap::IndexedReader::open(whole_source);
  ASSERT_TRUE(reader);
  for (const std::uint64_t offset :
       {std::uint64_t{0}, std::uint64_t{8}, file.size() - 1, ~std::uint64_t{0}}) {
    mcap::FileIndex index = reader->index();
    index.chunks.front().chunk_offset = offset;
    for (auto& [channel, at] : index.chunks.front().message_index_offsets) {
      at = offset;
    }
    Buffer bad(file.begin(), file.end());
    const test::Streamed whole = test::stream(file);
    bad.resize(static_cast<std::size_t>(whole.whole_until));
    append_summary(bad, index, bad.size(), 0);
    const mcap::MemorySource source(bad);
    auto hostile = mcap::IndexedReader::open(source);
    ASSERT_TRUE(hostile) << offset;
    EXPECT_FALSE(hostile->next()) << offset;
  }
}

}  // namespace
}  // namespace stof
