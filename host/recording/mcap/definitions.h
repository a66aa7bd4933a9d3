#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "host/recording/mcap/file_index.h"
#include "host/recording/mcap/limits.h"

namespace stof::mcap {

// Schemas and channels of a file as they are read. An id that stands for something else later (two
// files one behind the other) gets another one in the index.
class Definitions {
 public:
  // Another file begins: its ids mean nothing yet.
  void forget();
  // False: one of too many, or a channel without its schema.
  bool take(Schema&& schema, FileIndex& index, const Limits& limits);
  bool take(Channel&& channel, FileIndex& index, const Limits& limits);
  // The id in the index of a channel that the file calls `id`.
  std::optional<std::uint16_t> channel(std::uint16_t id) const;
  // Every id in the index is that of the file.
  bool as_in_file() const noexcept { return as_in_file_; }

 private:
  template <typename T>
  bool place(std::uint16_t id, T value, std::map<std::uint16_t, T>& all,
             std::map<std::uint16_t, std::uint16_t>& ids, const Limits& limits);

  std::map<std::uint16_t, std::uint16_t> schemas_;
  std::map<std::uint16_t, std::uint16_t> channels_;
  bool as_in_file_ = true;
};

}  // namespace stof::mcap
