#include "host/recording/mcap/chunk.h"

#include "host/recording/mcap/crc32.h"
#include "host/recording/mcap/zstd.h"

namespace stof::mcap {

std::unexpected<Problem> damaged(std::string_view what, std::uint64_t offset,
                                 std::string_view why) {
  std::string message = "damaged: ";
  message.append(what).append(" at byte ").append(std::to_string(offset)).append(": ").append(why);
  return std::unexpected(Problem{std::move(message)});
}

std::optional<RecordAt> first_record(Bytes bytes) {
  Cursor from(bytes);
  RecordAt record;
  record.opcode = static_cast<Opcode>(from.number<std::uint8_t>());
  const auto length = from.number<std::uint64_t>();
  record.content = from.bytes(length);
  if (!from.ok()) {
    return std::nullopt;
  }
  record.length = kRecordHead + length;
  return record;
}

std::expected<void, Unreadable> unpack(const Chunk& chunk, const Limits& limits, Buffer& out,
                                       std::uint64_t room) {
  const auto refuse = [](std::string_view why, bool damaged = true) {
    return std::unexpected(Unreadable{.why = why, .damaged = damaged});
  };
  if (chunk.uncompressed_size > limits.chunk_bytes) {
    return refuse("it says that it holds more than any chunk", false);
  }
  const auto size = static_cast<std::size_t>(chunk.uncompressed_size);
  if (chunk.compression.empty()) {
    if (chunk.records.size() != size) {
      return refuse("its lengths contradict each other");
    }
    out.assign(chunk.records.begin(), chunk.records.end());
  } else if (chunk.compression == "zstd") {
    // Before memory is asked for.
    if (chunk.uncompressed_size > most_zstd_bytes(chunk.records.size())) {
      return refuse("it says that it holds more than it can");
    }
    if (size > kAnyRatioBytes && size / kMostRatio > chunk.records.size()) {
      return refuse("it would be more than 1024 times as large unpacked", false);
    }
    if (size > room) {
      return refuse("the file would be more than 4096 times as large unpacked", false);
    }
    out.resize(size);
    if (!decompress_zstd(chunk.records, out)) {
      out.clear();
      return refuse("it cannot be decompressed");
    }
  } else {
    return refuse("its compression is not known here (zstd is)", false);
  }
  if (chunk.uncompressed_crc != 0 && crc32(out) != chunk.uncompressed_crc) {
    out.clear();
    return refuse("its CRC is another one");
  }
  return {};
}

}  // namespace stof::mcap
