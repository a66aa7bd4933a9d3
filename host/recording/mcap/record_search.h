#pragma once

#include <cstdint>
#include <optional>

#include "host/recording/mcap/limits.h"
#include "host/recording/mcap/records.h"
#include "host/recording/mcap/storage.h"

// Where the records of a file go on behind damage.
namespace stof::mcap {

class RecordSearch {
 public:
  // The source outlives it.
  RecordSearch(const ByteSource& source, const Limits& limits);

  // Whether the file ends at `offset`, or the head there can be that of a record of a data section,
  // or a file begins.
  bool credible(std::uint64_t offset) const;
  // Begin of the first sound record of a data section at `from` or behind: a chunk or an attachment
  // whose CRC is right, metadata, a file's magic and header, or definitions, message indexes and
  // messages outside of chunks that lead to one of these or are four in a row. Nothing: there is
  // none, or see gave_up().
  std::optional<std::uint64_t> next(std::uint64_t from);
  // What looked like records was too much to try: a file that was made for it. Something sound may
  // follow.
  bool gave_up() const noexcept { return work_left_ == 0; }

 private:
  struct Head {
    Opcode opcode{};
    std::uint64_t length = 0;  // of the content
  };
  std::optional<Head> head_at(std::uint64_t offset) const;
  bool possible(const Head& head, std::uint64_t offset) const;
  bool file_begins(std::uint64_t offset) const;
  bool sound(std::uint64_t offset);
  bool sound_chunk();                        // in buffer_
  bool spend(std::uint64_t bytes) noexcept;  // false: none are left

  const ByteSource* source_;
  Limits limits_;
  std::uint64_t work_left_;  // bytes that may be read and unpacked on trial
  Buffer buffer_;
};

// Of a kind without a CRC: whether its fields are there and fill the content.
bool fields_fill(Opcode opcode, Bytes content);

// Whether `content` is all of such a record, without a byte behind its fields.
bool is_exactly(const Chunk& chunk, Bytes content);
bool is_exactly(const Attachment& attachment, Bytes content);

// How a file whose data end ends at `from` goes on: records of a summary, a footer and the magic.
struct FileEnd {
  bool whole = false;    // all of that is there
  std::uint64_t at = 0;  // behind it; else where it breaks off
};
FileEnd end_of_file(const ByteSource& source, std::uint64_t from);

}  // namespace stof::mcap
