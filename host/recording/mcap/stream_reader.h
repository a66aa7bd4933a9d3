#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "host/recording/mcap/definitions.h"
#include "host/recording/mcap/file_index.h"
#include "host/recording/mcap/index_check.h"
#include "host/recording/mcap/limits.h"
#include "host/recording/mcap/record_at.h"
#include "host/recording/mcap/record_search.h"
#include "host/recording/mcap/storage.h"

namespace stof::mcap {

// What a reader delivers. What it borrows is valid until the reader's next call.
using Item = std::variant<Message, Attachment, Metadata>;

// From the first byte to the last, as it was written; needs no index. Behind damage it goes on at
// the next sound record. Where the file has a sound index, each record that it names has to be
// there.
class StreamReader {
 public:
  enum class End : std::uint8_t {
    kNotYet,
    kWhole,    // data end, summary, footer and magic are there, and nothing else
    kCut,      // the file ends within a record, or before its footer; nothing sound follows
    kDamaged,  // what follows cannot be a record, and nothing sound follows
  };

  // The source outlives it. A problem: not an MCAP file, or its header is cut.
  static std::expected<StreamReader, Problem> open(const ByteSource& source,
                                                   const Limits& limits = {});

  // The next item; nothing at the end, see end(). A problem says what is wrong with one record, or
  // with what lies where one should begin: the next call goes on behind it.
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
  // In damaged records, and between records, of what was read so far.
  std::uint64_t damaged_bytes() const noexcept { return damaged_bytes_; }
  // The index at the end of the file is sound, and names all chunks, attachments and metadata that
  // were found, and no others. Once end() is known.
  bool indexed() const noexcept { return index_check_.agrees(); }
  // In place an index can be made of index(), and what is damaged at the end be cut: ids are those
  // of the file, the index that is there names nothing that is none, nothing sound can lie behind
  // whole_until(), and no chunk with sound bytes was refused.
  bool can_index_in_place() const noexcept {
    return definitions_.as_in_file() && !index_check_.names_what_is_absent() && !unreadable_ &&
           !search_.gave_up();
  }
  // Files that were begun, one behind the other: 1, mostly.
  std::uint32_t files() const noexcept { return files_; }
  // Bytes of the file that were read.
  std::uint64_t position() const noexcept { return at_; }
  const Header& header() const noexcept { return header_; }
  bool chunked() const noexcept { return !loose_messages_; }  // all messages lie in chunks
  // Every chunk but the last one has a sound message index for each of its channels behind it.
  bool earlier_chunks_indexed() const noexcept { return earlier_chunks_indexed_; }

 private:
  explicit StreamReader(const ByteSource& source, const Limits& limits)
      : source_(&source), limits_(limits), search_(source, limits) {}

  // Into record_; false: end_ says why.
  std::expected<bool, Problem> read_record();
  std::expected<bool, Problem> skip_to_next_record(End otherwise);
  void stop(End end) noexcept;
  // A problem with record_. framed: its length is right for sure.
  std::unexpected<Problem> fail(std::string_view what, std::string_view why, bool framed = false);
  std::expected<void, Problem> judge_unknown();
  std::expected<void, Problem> judge_end();
  std::expected<std::optional<Item>, Problem> take();
  std::expected<std::optional<Item>, Problem> take_in_chunk();
  std::expected<std::optional<Item>, Problem> take_attachment();
  std::expected<std::optional<Item>, Problem> take_metadata();
  std::expected<void, Problem> take_data_end();
  std::expected<void, Problem> open_chunk();
  std::expected<void, Problem> judge_chunk(
      std::uint64_t packed_bytes, std::map<std::uint16_t, MessageIndex>& messages_by_channel);
  bool take_definition(Opcode opcode, Bytes content);
  std::optional<std::uint16_t> indexed_channel(Bytes content) const;
  std::expected<void, Problem> take_message_index();

  const ByteSource* source_;
  Limits limits_;
  RecordSearch search_;
  Definitions definitions_;
  Header header_;
  FileIndex index_;
  IndexCheck index_check_;
  bool unreadable_ = false;  // a chunk that is not damaged
  std::uint64_t damaged_bytes_ = 0;
  std::uint64_t unpacked_bytes_ = 0;  // of all chunks
  std::uint32_t files_ = 1;
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

}  // namespace stof::mcap
