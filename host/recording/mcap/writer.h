#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <expected>
#include <map>
#include <string>
#include <string_view>

#include "host/recording/mcap/crc32.h"
#include "host/recording/mcap/file_index.h"
#include "host/recording/mcap/storage.h"
#include "host/recording/mcap/zstd.h"

namespace stof::mcap {

struct WriterOptions {
  std::string profile = "ros2";
  std::string library{};
  std::size_t chunk_bytes = std::size_t{4} << 20;  // a chunk ends with the message that reaches it
  int zstd_level = 1;
};

// Writes one file. Every problem is final: after it only rescue() may be called. Not for two
// threads at once. The sink outlives it.
class Writer {
 public:
  // Writes the magic and the header: so a disk that takes nothing is found here.
  static std::expected<Writer, Problem> begin(ByteSink& sink, const WriterOptions& options);
  // Goes on in the data section of a file that is there up to `position` and has this CRC up to it.
  static Writer resume(ByteSink& sink, const WriterOptions& options, FileIndex index,
                       std::uint64_t position, const Crc32& data_crc);
  // Writes schema (once for each name; without a name none) and channel at once, before the chunk
  // that is being filled.
  std::expected<std::uint16_t, Problem> add_channel(std::string_view topic,
                                                    std::string_view message_encoding,
                                                    const Schema& schema, const TextMap& metadata);
  // channel_id: of add_channel(). Copies the data. Writes a chunk where that is full.
  std::expected<void, Problem> add_message(const Message& message);
  std::expected<void, Problem> add_attachment(const Attachment& attachment);
  std::expected<void, Problem> add_metadata(const Metadata& metadata);

  // Ends the chunk, where it holds a message, and waits until all is on the disk.
  std::expected<void, Problem> flush();
  // Ends the file: the last chunk, the index, and what flush() does.
  std::expected<void, Problem> finish();
  // After a problem: ends the file where what was written whole ends, with an index; where there is
  // no room for it, up to eight chunks give way, the last one first. False: without an index, of
  // whole records.
  bool rescue();

  // Bytes written without the index, and of the file with the one that was written last.
  std::uint64_t position() const noexcept { return position_; }
  std::uint64_t bytes() const noexcept { return position_ + end_bytes_; }
  const FileIndex& index() const noexcept { return index_; }

 private:
  // Where a chunk begins, to return there.
  struct Mark {
    std::uint64_t position = 0;
    Crc32 data_crc{};
    std::map<std::uint16_t, std::uint64_t> messages{};  // of the chunk, by channel
  };

  Writer(ByteSink& sink, const WriterOptions& options);
  std::expected<void, Problem> put(Bytes bytes);
  std::expected<void, Problem> write_chunk();
  std::expected<void, Problem> write_end();
  void return_to(const Mark& mark);

  ByteSink* sink_;
  WriterOptions options_;
  ZstdCompressor compressor_;
  FileIndex index_;
  std::uint64_t position_ = 0;
  std::uint64_t end_bytes_ = 0;
  Crc32 data_crc_;
  Buffer chunk_;  // records
  std::map<std::uint16_t, MessageIndex> chunk_index_;
  std::uint64_t chunk_start_ = 0;
  std::uint64_t chunk_end_ = 0;
  Buffer out_;
  std::deque<Mark> marks_;  // of the last chunks
};

}  // namespace stof::mcap
