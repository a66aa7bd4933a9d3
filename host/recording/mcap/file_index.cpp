#include "host/recording/mcap/file_index.h"

#include "host/recording/mcap/crc32.h"
#include "host/recording/mcap/record_bytes.h"

namespace stof::mcap {

void append_summary(Buffer& to, const FileIndex& index, std::uint64_t position,
                    std::uint32_t data_crc) {
  const std::size_t before = to.size();
  const auto place = [&] { return position + (to.size() - before); };
  append_data_end(to, data_crc);

  const std::size_t summary = to.size();
  const std::uint64_t summary_start = place();
  Buffer offsets;
  const auto group = [&](Opcode opcode, const auto& add) {
    const std::uint64_t start = place();
    add();
    if (place() != start) {
      append_summary_offset(offsets, opcode, start, place() - start);
    }
  };
  const auto all_of = [&](const auto& list) {
    return [&] {
      for (const auto& one : list) {
        append(to, one);
      }
    };
  };
  const auto values_of = [&](const auto& map) {
    return [&] {
      for (const auto& [id, one] : map) {
        append(to, one);
      }
    };
  };
  group(Opcode::kSchema, values_of(index.schemas));
  group(Opcode::kChannel, values_of(index.channels));
  group(Opcode::kStatistics, [&] {
    Statistics statistics = index.statistics;
    statistics.schema_count = static_cast<std::uint16_t>(index.schemas.size());
    statistics.channel_count = static_cast<std::uint32_t>(index.channels.size());
    append(to, statistics);
  });
  group(Opcode::kChunkIndex, all_of(index.chunks));
  group(Opcode::kAttachmentIndex, all_of(index.attachments));
  group(Opcode::kMetadataIndex, all_of(index.metadata));

  const std::uint64_t offset_start = place();
  append_bytes(to, offsets);
  const std::size_t footer = to.size();
  append(to, Footer{.summary_start = summary_start, .summary_offset_start = offset_start});
  constexpr std::size_t kCrc = 4;
  const Bytes covered =
      Bytes(to).subspan(summary, footer + kRecordHead + kFooterContent - kCrc - summary);
  const std::uint32_t crc = crc32(covered);
  std::memcpy(to.data() + to.size() - kCrc, &crc, kCrc);
  append_bytes(to, std::as_bytes(std::span(kMagic)));
}

}  // namespace stof::mcap
