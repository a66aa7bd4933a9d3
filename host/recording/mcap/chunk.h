#pragma once

#include <expected>
#include <optional>

#include "host/recording/mcap/reader.h"

// What both readers do with records.
namespace stof::mcap {

// "damaged: chunk at byte 12: its CRC is another one".
std::unexpected<Problem> damaged(std::string_view what, std::uint64_t offset, std::string_view why);

// The head of the record that begins at the begin of `bytes`: its content is there, or nothing.
std::optional<RecordAt> first_record(Bytes bytes);

// The content of a chunk record that begins at `offset`, into `out`.
std::expected<void, Problem> unpack(const Chunk& chunk, std::uint64_t offset, const Limits& limits,
                                    Buffer& out);

}  // namespace stof::mcap
