#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <set>
#include <string>
#include <variant>

#include "host/recording/mcap/file_index.h"
#include "host/recording/mcap/storage.h"

// Readers of MCAP files that may hold any bytes: nothing outside the file is read, and memory is
// bounded by Limits. Chunks are stored or of zstd.
namespace stof::mcap {

struct Limits {
  std::uint64_t record_bytes = std::uint64_t{256} << 20;  // of one record, and of the summary
  std::uint64_t chunk_bytes = std::uint64_t{256} << 20;   // of one chunk's content
  std::size_t channels = 4096;                            // and schemas
};

// What a reader delivers. What it borrows is valid until the reader's next call.
using Item = std::variant<Message, Attachment, Metadata>;

// One record of a file: where it begins, and its content.
struct RecordAt {
  Opcode opcode = Opcode::kHeader;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;  // of the whole record
  Bytes content{};           // borrowed
};

// From the first byte to the last, as it was written; needs no index.
class StreamReader {
 public:
  enum class End : std::uint8_t {
    kNotYet,
    kWhole,    // data end, footer and magic are there
    kCut,      // the file ends within a record, or before its data end
    kDamaged,  // what follows cannot be a record
  };

  // The source outlives it. A problem: not an MCAP file, or its header is cut.
  static std::expected<StreamReader, Problem> open(const ByteSource& source,
                                                   const Limits& limits = {});

  // The next item; nothing at the end, see end(). A problem says what is wrong with one record: the
  // next call goes on behind it.
  std::expected<std::optional<Item>, Problem> next();

  End end() const noexcept { return end_; }
  // Begin of the first byte that is not part of a whole record, once end() is known; of a whole
  // file: begin of its data end.
  std::uint64_t whole_until() const noexcept { return whole_until_; }
  // Of what was read so far: schemas, channels, chunks with their message indexes, what lies beside
  // them, and statistics. Chunks that were a problem are not in it.
  const FileIndex& index() const noexcept { return index_; }
  // Of the last chunk in index(): its messages as they were read.
  const std::map<std::uint16_t, MessageIndex>& chunk_messages() const noexcept {
    return chunk_messages_;
  }
  // Begin of the record that was read last: of the one that a problem is about.
  std::uint64_t record_offset() const noexcept { return record_.offset; }
  const Header& header() const noexcept { return header_; }
  bool chunked() const noexcept { return !loose_messages_; }  // all messages lie in chunks
  // Every chunk but the last one has a sound message index for each of its channels behind it.
  bool earlier_chunks_indexed() const noexcept { return earlier_chunks_indexed_; }

 private:
  explicit StreamReader(const ByteSource& source, const Limits& limits)
      : source_(&source), limits_(limits) {}

  bool read_record();  // into record_; false: end_ says why
  void stop(End end) noexcept;
  std::expected<std::optional<Item>, Problem> take();
  std::expected<std::optional<Item>, Problem> take_in_chunk();
  std::expected<std::optional<Item>, Problem> take_attachment();
  std::expected<std::optional<Item>, Problem> take_metadata();
  void take_data_end();
  std::expected<void, Problem> open_chunk();
  std::expected<void, Problem> judge_chunk(
      std::map<std::uint16_t, MessageIndex>& messages_by_channel);
  std::expected<void, Problem> take_definition(Opcode opcode, Bytes content);
  void take_message_index();

  const ByteSource* source_;
  Limits limits_;
  Header header_;
  FileIndex index_;
  End end_ = End::kNotYet;
  std::uint64_t at_ = 0;
  std::uint64_t whole_until_ = 0;
  Buffer buffer_;
  RecordAt record_;
  Buffer chunk_;
  std::size_t chunk_at_ = 0;  // == chunk_.size(): none is open
  std::map<std::uint16_t, MessageIndex> chunk_messages_;
  bool chunk_sound_ = false;  // the last one
  bool loose_messages_ = false;
  bool earlier_chunks_indexed_ = true;
};

// By the index at the end of the file: in order of chunks, in a chunk of times, and only what is
// asked for.
class IndexedReader {
 public:
  // The source outlives it. A problem: no MCAP file, or none with a whole index.
  static std::expected<IndexedReader, Problem> open(const ByteSource& source,
                                                    const Limits& limits = {});

  const FileIndex& index() const noexcept { return index_; }
  // Only these channels from now on, from the first message again. None named: all.
  void choose(std::set<std::uint16_t> channels);
  // A problem is of one chunk: the next call goes on behind it.
  std::expected<std::optional<Message>, Problem> next();

  // Any number of times, beside next(); borrowed until the next call.
  std::expected<Attachment, Problem> attachment(const AttachmentIndex& index);
  std::expected<Metadata, Problem> metadata(const MetadataIndex& index);

 private:
  IndexedReader(const ByteSource& source, const Limits& limits)
      : source_(&source), limits_(limits) {}

  std::expected<void, Problem> read_summary();
  std::expected<void, Problem> take_summary_record(const RecordAt& record);
  std::expected<void, Problem> open_chunk(const ChunkIndex& chunk);
  std::expected<void, Problem> read_entries(const ChunkIndex& chunk);
  std::expected<RecordAt, Problem> record_at(std::uint64_t offset, std::uint64_t length);
  bool wanted(std::uint16_t channel) const { return chosen_.empty() || chosen_.contains(channel); }

  struct Entry {
    IndexEntry message{};
    std::uint16_t channel = 0;
  };

  const ByteSource* source_;
  Limits limits_;
  FileIndex index_;
  std::set<std::uint16_t> chosen_;
  std::size_t next_chunk_ = 0;
  std::vector<Entry> entries_;  // of the open chunk
  std::size_t next_entry_ = 0;
  Buffer buffer_;
  Buffer chunk_;
};

}  // namespace stof::mcap
