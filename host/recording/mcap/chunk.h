#pragma once

#include <expected>
#include <optional>
#include <string_view>

#include "host/recording/mcap/limits.h"
#include "host/recording/mcap/record_at.h"
#include "host/recording/mcap/storage.h"

// What both readers do with records.
namespace stof::mcap {

// "damaged: chunk at byte 12: its CRC is another one".
std::unexpected<Problem> damaged(std::string_view what, std::uint64_t offset, std::string_view why);

// The head of the record that begins at the begin of `bytes`: its content is there, or nothing.
std::optional<RecordAt> first_record(Bytes bytes);

// Why a chunk has no content here. damaged: nobody can read it; else another reader may.
struct Unreadable {
  std::string_view why{};
  bool damaged = true;
};

// The content of a chunk into `out`. room: bytes that it may unpack to, beside the limits.
std::expected<void, Unreadable> unpack(const Chunk& chunk, const Limits& limits, Buffer& out,
                                       std::uint64_t room = ~std::uint64_t{0});

}  // namespace stof::mcap
