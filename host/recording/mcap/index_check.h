#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>

#include "host/recording/mcap/file_index.h"

namespace stof::mcap {

// Holds the index at the end of a file against what is read of it.
class IndexCheck {
 public:
  // The file has a sound index: this one.
  void begin(const FileIndex& index) {
    indexed_ = true;
    for (const ChunkIndex& chunk : index.chunks) {
      named_.insert(chunk.chunk_offset);
      for (const auto& [channel, offset] : chunk.message_index_offsets) {
        named_.insert(offset);
      }
    }
    for (const AttachmentIndex& attachment : index.attachments) {
      named_.insert(attachment.offset);
    }
    for (const MetadataIndex& metadata : index.metadata) {
      named_.insert(metadata.offset);
    }
  }
  // A chunk, attachment or metadata record, which the index has to name.
  void found(std::uint64_t offset) { indexed_ = named_.erase(offset) != 0 && indexed_; }
  // A message index, which it may name.
  void found_message_index(std::uint64_t offset) { named_.erase(offset); }
  // What lies there was told to be damaged.
  void damaged(std::uint64_t begin, std::uint64_t end) {
    named_.erase(named_.lower_bound(begin), named_.lower_bound(std::max(end, begin + 1)));
  }

  struct Absent {
    std::uint64_t first = 0;  // offset
    std::size_t count = 0;
  };
  // At the end of the file: what it names and nobody found. Once.
  std::optional<Absent> take_absent() {
    if (named_.empty()) {
      return std::nullopt;
    }
    const Absent absent{.first = *named_.begin(), .count = named_.size()};
    named_.clear();
    indexed_ = false;
    absent_ = true;
    return absent;
  }

  // There is an index, and it names what was found.
  bool agrees() const noexcept { return indexed_; }
  bool names_what_is_absent() const noexcept { return absent_; }

 private:
  std::set<std::uint64_t> named_;  // and not found yet
  bool indexed_ = false;
  bool absent_ = false;
};

}  // namespace stof::mcap
