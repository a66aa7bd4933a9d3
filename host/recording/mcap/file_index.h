#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "host/recording/mcap/records.h"

namespace stof::mcap {

// What the summary at the end of a file says of it.
struct FileIndex {
  std::map<std::uint16_t, Schema> schemas{};
  std::map<std::uint16_t, Channel> channels{};
  std::vector<ChunkIndex> chunks{};
  std::vector<AttachmentIndex> attachments{};
  std::vector<MetadataIndex> metadata{};
  Statistics statistics{};  // but schema and channel count

  void count_message(std::uint16_t channel, std::uint64_t log_time) {
    Statistics& all = statistics;
    all.start_time = all.message_count == 0 ? log_time : std::min(all.start_time, log_time);
    all.end_time = std::max(all.end_time, log_time);
    ++all.message_count;
    ++all.messages_by_channel[channel];
  }
};

// Appends what ends a file whose data section has `position` bytes and this CRC (0: not told): data
// end, summary, summary offsets, footer, magic.
void append_summary(Buffer& to, const FileIndex& index, std::uint64_t position,
                    std::uint32_t data_crc);

}  // namespace stof::mcap
