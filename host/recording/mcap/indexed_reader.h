#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <set>
#include <vector>

#include "host/recording/mcap/file_index.h"
#include "host/recording/mcap/limits.h"
#include "host/recording/mcap/record_at.h"
#include "host/recording/mcap/storage.h"

namespace stof::mcap {

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
  // The next message is the first of the first chunk that holds a message of this time or later.
  void seek(std::uint64_t log_time);
  // Of the last message of a channel; none: it has none, or no index of it can be read.
  std::optional<std::uint64_t> last_time(std::uint16_t channel);
  // Of all messages of a channel, by chunk; what has no index that can be read is left out.
  std::vector<std::uint64_t> times(std::uint16_t channel);
  // The last message of a channel between both times, by the index: one chunk is unpacked. Any
  // number of times, beside next(); borrowed until the next call. None: there is none that can be
  // read.
  std::optional<Message> newest(std::uint16_t channel, std::uint64_t from, std::uint64_t until);
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
  std::expected<void, Problem> open_chunk(const ChunkIndex& chunk, Buffer& unpacked);
  std::optional<MessageIndex> messages_of(const ChunkIndex& chunk, std::uint16_t channel);
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
  Buffer beside_;  // of newest()
};

}  // namespace stof::mcap
