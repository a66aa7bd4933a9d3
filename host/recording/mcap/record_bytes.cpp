#include "host/recording/mcap/record_bytes.h"

#include "host/recording/mcap/crc32.h"

namespace stof::mcap {
namespace {

// Writes opcode and length around what is appended while it lives.
class Record {
 public:
  Record(Buffer& to, Opcode opcode) : to_(to) {
    append(to_, static_cast<std::uint8_t>(opcode));
    append(to_, std::uint64_t{0});
    begin_ = to_.size();
  }
  ~Record() {
    const std::uint64_t length = to_.size() - begin_;
    std::memcpy(to_.data() + begin_ - sizeof length, &length, sizeof length);
  }
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  Bytes content() const { return Bytes(to_).subspan(begin_); }

 private:
  Buffer& to_;
  std::size_t begin_ = 0;
};

// Length in bytes (u32), then key and value of each.
void append_map(Buffer& to, const TextMap& map) {
  Buffer entries;
  for (const auto& [key, value] : map) {
    append_text(entries, key);
    append_text(entries, value);
  }
  append(to, static_cast<std::uint32_t>(entries.size()));
  append_bytes(to, entries);
}
void append_map(Buffer& to, const std::map<std::uint16_t, std::uint64_t>& map) {
  append(to, static_cast<std::uint32_t>(map.size() * 10));
  for (const auto& [key, value] : map) {
    append(to, key);
    append(to, value);
  }
}

// Bad is the outer cursor, too, when the entries do not fill their length.
TextMap text_map(Cursor& from, bool& ok) {
  TextMap map;
  Cursor entries(from.bytes(from.number<std::uint32_t>()));
  while (entries.left() > 0) {
    std::string key = entries.text();
    map[std::move(key)] = entries.text();
  }
  ok = ok && entries.ok();
  return map;
}
std::map<std::uint16_t, std::uint64_t> number_map(Cursor& from, bool& ok) {
  std::map<std::uint16_t, std::uint64_t> map;
  Cursor entries(from.bytes(from.number<std::uint32_t>()));
  while (entries.left() > 0) {
    const auto key = entries.number<std::uint16_t>();
    map[key] = entries.number<std::uint64_t>();
  }
  ok = ok && entries.ok();
  return map;
}

template <typename T>
std::optional<T> if_ok(const Cursor& cursor, T value, bool ok = true) {
  return cursor.ok() && ok ? std::optional<T>(std::move(value)) : std::nullopt;
}

}  // namespace

void append(Buffer& to, const Header& value) {
  const Record record(to, Opcode::kHeader);
  append_text(to, value.profile);
  append_text(to, value.library);
}

void append(Buffer& to, const Footer& value) {
  const Record record(to, Opcode::kFooter);
  append(to, value.summary_start);
  append(to, value.summary_offset_start);
  append(to, value.summary_crc);
}

void append(Buffer& to, const Schema& value) {
  const Record record(to, Opcode::kSchema);
  append(to, value.id);
  append_text(to, value.name);
  append_text(to, value.encoding);
  append_text(to, value.data);
}

void append(Buffer& to, const Channel& value) {
  const Record record(to, Opcode::kChannel);
  append(to, value.id);
  append(to, value.schema_id);
  append_text(to, value.topic);
  append_text(to, value.message_encoding);
  append_map(to, value.metadata);
}

void append(Buffer& to, const Message& value) {
  const Record record(to, Opcode::kMessage);
  append(to, value.channel_id);
  append(to, value.sequence);
  append(to, value.log_time);
  append(to, value.publish_time);
  append_bytes(to, value.data);
}

void append(Buffer& to, const Chunk& value) {
  const Record record(to, Opcode::kChunk);
  append(to, value.start_time);
  append(to, value.end_time);
  append(to, value.uncompressed_size);
  append(to, value.uncompressed_crc);
  append_text(to, value.compression);
  append(to, std::uint64_t{value.records.size()});
  append_bytes(to, value.records);
}

void append(Buffer& to, const MessageIndex& value) {
  const Record record(to, Opcode::kMessageIndex);
  append(to, value.channel_id);
  append(to, static_cast<std::uint32_t>(value.entries.size() * 16));
  for (const IndexEntry& entry : value.entries) {
    append(to, entry.log_time);
    append(to, entry.offset);
  }
}

void append(Buffer& to, const ChunkIndex& value) {
  const Record record(to, Opcode::kChunkIndex);
  append(to, value.start_time);
  append(to, value.end_time);
  append(to, value.chunk_offset);
  append(to, value.chunk_length);
  append_map(to, value.message_index_offsets);
  append(to, value.message_index_length);
  append_text(to, value.compression);
  append(to, value.compressed_size);
  append(to, value.uncompressed_size);
}

void append(Buffer& to, const Attachment& value) {
  const Record record(to, Opcode::kAttachment);
  append(to, value.log_time);
  append(to, value.create_time);
  append_text(to, value.name);
  append_text(to, value.media_type);
  append(to, std::uint64_t{value.data.size()});
  append_bytes(to, value.data);
  append(to, crc32(record.content()));
}

void append(Buffer& to, const AttachmentIndex& value) {
  const Record record(to, Opcode::kAttachmentIndex);
  append(to, value.offset);
  append(to, value.length);
  append(to, value.log_time);
  append(to, value.create_time);
  append(to, value.data_size);
  append_text(to, value.name);
  append_text(to, value.media_type);
}

void append(Buffer& to, const Metadata& value) {
  const Record record(to, Opcode::kMetadata);
  append_text(to, value.name);
  append_map(to, value.entries);
}

void append(Buffer& to, const MetadataIndex& value) {
  const Record record(to, Opcode::kMetadataIndex);
  append(to, value.offset);
  append(to, value.length);
  append_text(to, value.name);
}

void append(Buffer& to, const Statistics& value) {
  const Record record(to, Opcode::kStatistics);
  append(to, value.message_count);
  append(to, value.schema_count);
  append(to, value.channel_count);
  append(to, value.attachment_count);
  append(to, value.metadata_count);
  append(to, value.chunk_count);
  append(to, value.start_time);
  append(to, value.end_time);
  append_map(to, value.messages_by_channel);
}

void append_summary_offset(Buffer& to, Opcode group, std::uint64_t start, std::uint64_t length) {
  const Record record(to, Opcode::kSummaryOffset);
  append(to, static_cast<std::uint8_t>(group));
  append(to, start);
  append(to, length);
}

void append_data_end(Buffer& to, std::uint32_t data_crc) {
  const Record record(to, Opcode::kDataEnd);
  append(to, data_crc);
}

std::optional<Header> parse_header(Bytes content) {
  Cursor from(content);
  Header value;
  value.profile = from.text();
  value.library = from.text();
  return if_ok(from, std::move(value));
}

std::optional<Footer> parse_footer(Bytes content) {
  Cursor from(content);
  Footer value;
  value.summary_start = from.number<std::uint64_t>();
  value.summary_offset_start = from.number<std::uint64_t>();
  value.summary_crc = from.number<std::uint32_t>();
  return if_ok(from, value);
}

std::optional<Schema> parse_schema(Bytes content) {
  Cursor from(content);
  Schema value;
  value.id = from.number<std::uint16_t>();
  value.name = from.text();
  value.encoding = from.text();
  value.data = from.text();
  const bool has_id = value.id != 0;
  return if_ok(from, std::move(value), has_id);
}

std::optional<Channel> parse_channel(Bytes content) {
  Cursor from(content);
  Channel value;
  bool ok = true;
  value.id = from.number<std::uint16_t>();
  value.schema_id = from.number<std::uint16_t>();
  value.topic = from.text();
  value.message_encoding = from.text();
  value.metadata = text_map(from, ok);
  return if_ok(from, std::move(value), ok);
}

std::optional<Message> parse_message(Bytes content) {
  Cursor from(content);
  Message value;
  value.channel_id = from.number<std::uint16_t>();
  value.sequence = from.number<std::uint32_t>();
  value.log_time = from.number<std::uint64_t>();
  value.publish_time = from.number<std::uint64_t>();
  value.data = from.rest();
  return if_ok(from, value);
}

std::optional<Chunk> parse_chunk(Bytes content) {
  Cursor from(content);
  Chunk value;
  value.start_time = from.number<std::uint64_t>();
  value.end_time = from.number<std::uint64_t>();
  value.uncompressed_size = from.number<std::uint64_t>();
  value.uncompressed_crc = from.number<std::uint32_t>();
  value.compression = from.text();
  value.records = from.bytes(from.number<std::uint64_t>());
  return if_ok(from, std::move(value));
}

std::optional<MessageIndex> parse_message_index(Bytes content) {
  Cursor from(content);
  MessageIndex value;
  value.channel_id = from.number<std::uint16_t>();
  Cursor entries(from.bytes(from.number<std::uint32_t>()));
  while (entries.left() > 0) {
    const auto log_time = entries.number<std::uint64_t>();
    value.entries.push_back({.log_time = log_time, .offset = entries.number<std::uint64_t>()});
  }
  return if_ok(from, std::move(value), entries.ok());
}

std::optional<ChunkIndex> parse_chunk_index(Bytes content) {
  Cursor from(content);
  ChunkIndex value;
  bool ok = true;
  value.start_time = from.number<std::uint64_t>();
  value.end_time = from.number<std::uint64_t>();
  value.chunk_offset = from.number<std::uint64_t>();
  value.chunk_length = from.number<std::uint64_t>();
  value.message_index_offsets = number_map(from, ok);
  value.message_index_length = from.number<std::uint64_t>();
  value.compression = from.text();
  value.compressed_size = from.number<std::uint64_t>();
  value.uncompressed_size = from.number<std::uint64_t>();
  return if_ok(from, std::move(value), ok);
}

std::optional<Attachment> parse_attachment(Bytes content) {
  Cursor from(content);
  Attachment value;
  value.log_time = from.number<std::uint64_t>();
  value.create_time = from.number<std::uint64_t>();
  value.name = from.text();
  value.media_type = from.text();
  value.data = from.bytes(from.number<std::uint64_t>());
  const std::size_t covered = from.position();
  const auto crc = from.number<std::uint32_t>();
  return if_ok(from, std::move(value), crc == 0 || crc == crc32(content.first(covered)));
}

std::optional<AttachmentIndex> parse_attachment_index(Bytes content) {
  Cursor from(content);
  AttachmentIndex value;
  value.offset = from.number<std::uint64_t>();
  value.length = from.number<std::uint64_t>();
  value.log_time = from.number<std::uint64_t>();
  value.create_time = from.number<std::uint64_t>();
  value.data_size = from.number<std::uint64_t>();
  value.name = from.text();
  value.media_type = from.text();
  return if_ok(from, std::move(value));
}

std::optional<Metadata> parse_metadata(Bytes content) {
  Cursor from(content);
  Metadata value;
  bool ok = true;
  value.name = from.text();
  value.entries = text_map(from, ok);
  return if_ok(from, std::move(value), ok);
}

std::optional<MetadataIndex> parse_metadata_index(Bytes content) {
  Cursor from(content);
  MetadataIndex value;
  value.offset = from.number<std::uint64_t>();
  value.length = from.number<std::uint64_t>();
  value.name = from.text();
  return if_ok(from, std::move(value));
}

std::optional<Statistics> parse_statistics(Bytes content) {
  Cursor from(content);
  Statistics value;
  bool ok = true;
  value.message_count = from.number<std::uint64_t>();
  value.schema_count = from.number<std::uint16_t>();
  value.channel_count = from.number<std::uint32_t>();
  value.attachment_count = from.number<std::uint32_t>();
  value.metadata_count = from.number<std::uint32_t>();
  value.chunk_count = from.number<std::uint32_t>();
  value.start_time = from.number<std::uint64_t>();
  value.end_time = from.number<std::uint64_t>();
  value.messages_by_channel = number_map(from, ok);
  return if_ok(from, std::move(value), ok);
}

}  // namespace stof::mcap
