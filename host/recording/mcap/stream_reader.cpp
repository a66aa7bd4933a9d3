#include <algorithm>

#include "host/recording/mcap/chunk.h"
#include "host/recording/mcap/reader.h"
#include "host/recording/mcap/record_bytes.h"

namespace stof::mcap {

std::expected<StreamReader, Problem> StreamReader::open(const ByteSource& source,
                                                        const Limits& limits) {
  StreamReader reader(source, limits);
  std::array<std::byte, kMagic.size()> magic{};
  if (!source.read(0, magic) || !std::ranges::equal(magic, std::as_bytes(std::span(kMagic)))) {
    return std::unexpected(Problem{"is not an MCAP file: give a recording"});
  }
  reader.at_ = magic.size();
  if (!reader.read_record() || reader.record_.opcode != Opcode::kHeader) {
    return std::unexpected(Problem{"is an MCAP file without a header: nothing can be read"});
  }
  std::optional<Header> header = parse_header(reader.record_.content);
  if (!header) {
    return std::unexpected(Problem{"is an MCAP file with a damaged header: nothing can be read"});
  }
  reader.header_ = std::move(*header);
  return reader;
}

void StreamReader::stop(End end) noexcept {
  end_ = end;
  whole_until_ = at_;
}

bool StreamReader::read_record() {
  std::array<std::byte, kRecordHead> head{};
  if (!source_->read(at_, head)) {
    stop(End::kCut);
    return false;
  }
  Cursor from(head);
  record_.opcode = static_cast<Opcode>(from.number<std::uint8_t>());
  const auto length = from.number<std::uint64_t>();
  record_.offset = at_;
  if (record_.opcode == Opcode{0}) {  // what a file system leaves of bytes that were not flushed
    stop(End::kDamaged);
    return false;
  }
  if (length > source_->size() - at_ - kRecordHead) {
    stop(End::kCut);
    return false;
  }
  if (length > limits_.record_bytes) {
    stop(End::kDamaged);
    return false;
  }
  buffer_.resize(static_cast<std::size_t>(length));
  if (!source_->read(at_ + kRecordHead, buffer_)) {
    stop(End::kCut);
    return false;
  }
  record_.length = kRecordHead + length;
  record_.content = buffer_;
  at_ += record_.length;
  return true;
}

std::expected<std::optional<Item>, Problem> StreamReader::next() {
  while (end_ == End::kNotYet) {
    auto item = chunk_at_ < chunk_.size() ? take_in_chunk() : take();
    if (!item || item->has_value()) {
      return item;
    }
  }
  return std::optional<Item>();
}

std::expected<std::optional<Item>, Problem> StreamReader::take() {
  if (!read_record()) {
    return std::optional<Item>();
  }
  const std::uint64_t offset = record_.offset;
  switch (record_.opcode) {
    case Opcode::kSchema:
    case Opcode::kChannel:
      if (auto done = take_definition(record_.opcode, record_.content); !done) {
        return std::unexpected(done.error());
      }
      break;
    case Opcode::kMessage: {
      const std::optional<Message> message = parse_message(record_.content);
      if (!message || !index_.channels.contains(message->channel_id)) {
        return damaged("message", offset, "it is cut, or of a channel that is not there");
      }
      loose_messages_ = true;
      index_.count_message(message->channel_id, message->log_time);
      return Item(*message);
    }
    case Opcode::kChunk:
      if (auto done = open_chunk(); !done) {
        return std::unexpected(done.error());
      }
      break;
    case Opcode::kMessageIndex:
      take_message_index();
      break;
    case Opcode::kAttachment:
      return take_attachment();
    case Opcode::kMetadata:
      return take_metadata();
    case Opcode::kDataEnd:
      take_data_end();
      break;
    default:
      break;  // of a newer writer
  }
  return std::optional<Item>();
}

std::expected<std::optional<Item>, Problem> StreamReader::take_attachment() {
  const std::uint64_t offset = record_.offset;
  std::optional<Attachment> attachment = parse_attachment(record_.content);
  if (!attachment) {
    return damaged("attachment", offset, "it is cut, or its CRC is another one");
  }
  index_.attachments.push_back({.offset = offset,
                                .length = record_.length,
                                .log_time = attachment->log_time,
                                .create_time = attachment->create_time,
                                .data_size = attachment->data.size(),
                                .name = attachment->name,
                                .media_type = attachment->media_type});
  ++index_.statistics.attachment_count;
  return Item(std::move(*attachment));
}

std::expected<std::optional<Item>, Problem> StreamReader::take_metadata() {
  const std::uint64_t offset = record_.offset;
  std::optional<Metadata> metadata = parse_metadata(record_.content);
  if (!metadata) {
    return damaged("metadata", offset, "it is cut");
  }
  index_.metadata.push_back({.offset = offset, .length = record_.length, .name = metadata->name});
  ++index_.statistics.metadata_count;
  return Item(std::move(*metadata));
}

void StreamReader::take_data_end() {
  const std::uint64_t offset = record_.offset;
  std::array<std::byte, kMagic.size()> magic{};
  const std::uint64_t size = source_->size();
  at_ = offset;
  const bool whole = source_->read(size - magic.size(), magic) &&
                     std::ranges::equal(magic, std::as_bytes(std::span(kMagic))) &&
                     size >= offset + record_.length + kRecordHead + kFooterContent;
  stop(whole ? End::kWhole : End::kCut);
}

std::expected<void, Problem> StreamReader::open_chunk() {
  chunk_.clear();
  chunk_at_ = 0;
  chunk_sound_ = false;
  if (!index_.chunks.empty() &&
      index_.chunks.back().message_index_offsets.size() != chunk_messages_.size()) {
    earlier_chunks_indexed_ = false;
  }
  const std::optional<Chunk> chunk = parse_chunk(record_.content);
  if (!chunk) {
    return damaged("chunk", record_.offset, "its lengths contradict each other");
  }
  if (auto done = unpack(*chunk, record_.offset, limits_, chunk_); !done) {
    return done;
  }
  std::map<std::uint16_t, MessageIndex> messages_by_channel;
  if (auto done = judge_chunk(messages_by_channel); !done) {
    chunk_.clear();
    return done;
  }
  chunk_messages_ = std::move(messages_by_channel);
  index_.chunks.push_back({.start_time = chunk->start_time,
                           .end_time = chunk->end_time,
                           .chunk_offset = record_.offset,
                           .chunk_length = record_.length,
                           .compression = chunk->compression,
                           .compressed_size = chunk->records.size(),
                           .uncompressed_size = chunk->uncompressed_size});
  ++index_.statistics.chunk_count;
  chunk_sound_ = true;
  for (const auto& [channel, messages] : chunk_messages_) {
    for (const IndexEntry& entry : messages.entries) {
      index_.count_message(channel, entry.log_time);
    }
  }
  return {};
}

// Goes through all records once, so that a chunk is delivered whole or not at all.
std::expected<void, Problem> StreamReader::judge_chunk(
    std::map<std::uint16_t, MessageIndex>& messages_by_channel) {
  const std::uint64_t chunk = record_.offset;
  for (std::size_t at = 0; at < chunk_.size();) {
    const std::optional<RecordAt> record = first_record(Bytes(chunk_).subspan(at));
    if (!record) {
      return damaged("chunk", chunk, "a record in it is cut");
    }
    if (record->opcode == Opcode::kSchema || record->opcode == Opcode::kChannel) {
      if (auto done = take_definition(record->opcode, record->content); !done) {
        return done;
      }
    } else if (record->opcode == Opcode::kMessage) {
      const std::optional<Message> message = parse_message(record->content);
      if (!message || !index_.channels.contains(message->channel_id)) {
        return damaged("chunk", chunk, "a message in it is cut, or of a channel that is not there");
      }
      MessageIndex& messages = messages_by_channel[message->channel_id];
      messages.channel_id = message->channel_id;
      messages.entries.push_back({.log_time = message->log_time, .offset = at});
    }
    at += static_cast<std::size_t>(record->length);
  }
  return {};
}

std::expected<std::optional<Item>, Problem> StreamReader::take_in_chunk() {
  const std::optional<RecordAt> record = first_record(Bytes(chunk_).subspan(chunk_at_));
  if (!record) {
    chunk_at_ = chunk_.size();
    return damaged("chunk", record_.offset, "a record in it is cut");
  }
  chunk_at_ += static_cast<std::size_t>(record->length);
  if (record->opcode == Opcode::kMessage) {
    if (const std::optional<Message> message = parse_message(record->content)) {
      return Item(*message);
    }
  }
  return std::optional<Item>();
}

std::expected<void, Problem> StreamReader::take_definition(Opcode opcode, Bytes content) {
  if (opcode == Opcode::kSchema) {
    std::optional<Schema> schema = parse_schema(content);
    if (!schema || index_.schemas.size() >= limits_.channels) {
      return damaged("schema", record_.offset, "it is cut, or one of too many");
    }
    index_.schemas.insert_or_assign(schema->id, std::move(*schema));
    return {};
  }
  std::optional<Channel> channel = parse_channel(content);
  if (!channel || index_.channels.size() >= limits_.channels ||
      (channel->schema_id != 0 && !index_.schemas.contains(channel->schema_id))) {
    return damaged("channel", record_.offset, "it is cut, one of too many, or without its schema");
  }
  index_.channels.insert_or_assign(channel->id, std::move(*channel));
  return {};
}

// Where each index of the chunk before lies, if it says what was counted from the messages.
void StreamReader::take_message_index() {
  const std::optional<MessageIndex> messages = parse_message_index(record_.content);
  if (!messages || !chunk_sound_) {
    return;
  }
  const auto counted = chunk_messages_.find(messages->channel_id);
  if (counted == chunk_messages_.end() || counted->second.entries != messages->entries) {
    return;
  }
  ChunkIndex& chunk = index_.chunks.back();
  chunk.message_index_offsets[messages->channel_id] = record_.offset;
  chunk.message_index_length += record_.length;
}

}  // namespace stof::mcap
