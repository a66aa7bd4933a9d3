#include "host/recording/mcap/stream_reader.h"

#include <algorithm>

#include "host/recording/mcap/chunk.h"
#include "host/recording/mcap/indexed_reader.h"
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
  const auto read = reader.read_record();
  if (!read || !*read || reader.record_.opcode != Opcode::kHeader) {
    return std::unexpected(Problem{"is an MCAP file without a header: nothing can be read"});
  }
  std::optional<Header> header = parse_header(reader.record_.content);
  if (!header) {
    return std::unexpected(Problem{"is an MCAP file with a damaged header: nothing can be read"});
  }
  reader.header_ = std::move(*header);
  if (const auto indexed = IndexedReader::open(source, limits)) {
    reader.index_check_.begin(indexed->index());
  }
  return reader;
}

void StreamReader::stop(End end) noexcept {
  end_ = end;
  whole_until_ = at_;
}

std::unexpected<Problem> StreamReader::fail(std::string_view what, std::string_view why,
                                            bool framed) {
  const std::uint64_t offset = record_.offset;
  if (!framed && !search_.credible(at_)) {  // then its length may be what is wrong
    const std::optional<std::uint64_t> next = search_.next(offset + 1);
    at_ = next.value_or(offset);
    if (!next) {
      stop(End::kDamaged);
    }
  }
  damaged_bytes_ += at_ - offset;
  index_check_.damaged(offset, at_);
  return damaged(what, offset, why);
}

// Where no record begins at at_.
std::expected<bool, Problem> StreamReader::skip_to_next_record(End otherwise) {
  const std::optional<std::uint64_t> next = search_.next(at_ + 1);
  if (!next) {
    stop(otherwise);
    return false;
  }
  at_ = *next;
  return fail("record",
              "what lies there is none; the next one begins at byte " + std::to_string(at_), true);
}

std::expected<bool, Problem> StreamReader::read_record() {
  record_.offset = at_;
  std::array<std::byte, kRecordHead> head{};
  if (source_->read(at_, head) &&
      std::ranges::equal(Bytes(head).first(kMagic.size()), std::as_bytes(std::span(kMagic)))) {
    definitions_.forget();  // another file begins
    at_ += kMagic.size();
    record_.offset = at_;
  }
  if (!source_->read(at_, head)) {
    stop(End::kCut);
    return false;
  }
  Cursor from(head);
  record_.opcode = static_cast<Opcode>(from.number<std::uint8_t>());
  const auto length = from.number<std::uint64_t>();
  if (record_.opcode == Opcode{0}) {  // what a file system leaves of bytes that were not flushed
    return skip_to_next_record(End::kDamaged);
  }
  if (length > source_->size() - at_ - kRecordHead) {
    return skip_to_next_record(End::kCut);
  }
  if (length > limits_.record_bytes) {
    unreadable_ = true;
    return skip_to_next_record(End::kDamaged);
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
  if (auto done = judge_end(); !done) {
    return std::unexpected(done.error());
  }
  return std::optional<Item>();
}

// What the index names and nobody met, once.
std::expected<void, Problem> StreamReader::judge_end() {
  const std::optional<IndexCheck::Absent> absent = index_check_.take_absent();
  if (!absent) {
    return {};
  }
  return damaged("record", absent->first,
                 "the index at the end of the file names it, and " +
                     std::to_string(absent->count - 1) + " others that are not there either");
}

std::expected<std::optional<Item>, Problem> StreamReader::take() {
  const auto read = read_record();
  if (!read) {
    return std::unexpected(read.error());
  }
  if (!*read) {
    return std::optional<Item>();
  }
  std::expected<void, Problem> done;
  switch (record_.opcode) {
    case Opcode::kSchema:
    case Opcode::kChannel:
      if (!take_definition(record_.opcode, record_.content)) {
        return fail("definition", "it is cut, one of too many, or without its schema");
      }
      break;
    case Opcode::kMessage: {
      std::optional<Message> message = parse_message(record_.content);
      const std::optional<std::uint16_t> channel =
          message ? definitions_.channel(message->channel_id) : std::nullopt;
      if (!channel || indexed_channel(record_.content)) {
        return fail("message", "it is cut, or of a channel that is not there");
      }
      message->channel_id = *channel;
      loose_messages_ = true;
      index_.count_message(message->channel_id, message->log_time);
      return Item(*message);
    }
    case Opcode::kChunk:
      done = open_chunk();
      break;
    case Opcode::kMessageIndex:
      done = take_message_index();
      break;
    case Opcode::kAttachment:
      return take_attachment();
    case Opcode::kMetadata:
      return take_metadata();
    case Opcode::kDataEnd:
      done = take_data_end();
      break;
    default:
      done = judge_unknown();
      break;
  }
  if (!done) {
    return std::unexpected(done.error());
  }
  return std::optional<Item>();
}

std::expected<void, Problem> StreamReader::judge_unknown() {
  if (record_.opcode == Opcode::kHeader && record_.offset >= kMagic.size()) {
    std::array<std::byte, kMagic.size()> before{};
    if (source_->read(record_.offset - before.size(), before) &&
        std::ranges::equal(before, std::as_bytes(std::span(kMagic)))) {
      ++files_;
      return {};  // of a file behind the first one
    }
  }
  if (record_.opcode <= Opcode::kDataEnd) {
    return fail("record", "its kind does not belong there");
  }
  const std::optional<Chunk> chunk = parse_chunk(record_.content);
  Buffer content;
  if ((chunk && is_exactly(*chunk, record_.content) && unpack(*chunk, limits_, content)) ||
      parse_attachment(record_.content)) {
    return fail("record", "its content is of another kind than it says");
  }
  if (!search_.credible(at_)) {
    return fail("record", "its kind is not known, and what follows is none");
  }
  return {};  // of a newer writer
}

std::expected<std::optional<Item>, Problem> StreamReader::take_attachment() {
  const std::uint64_t offset = record_.offset;
  std::optional<Attachment> attachment = parse_attachment(record_.content);
  if (!attachment || !(is_exactly(*attachment, record_.content) || search_.credible(at_))) {
    return fail("attachment", "it is cut, or its CRC is another one");
  }
  index_check_.found(offset);
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
  if (!metadata || !(fields_fill(Opcode::kMetadata, record_.content) || search_.credible(at_))) {
    return fail("metadata", "it is cut");
  }
  index_check_.found(offset);
  index_.metadata.push_back({.offset = offset, .length = record_.length, .name = metadata->name});
  ++index_.statistics.metadata_count;
  return Item(std::move(*metadata));
}

std::expected<void, Problem> StreamReader::take_data_end() {
  const std::uint64_t offset = record_.offset;
  const FileEnd end = end_of_file(*source_, at_);
  const std::optional<std::uint64_t> next =
      end.at == source_->size() ? std::nullopt : search_.next(end.at);
  if (!next) {
    at_ = offset;
    const End of_whole = end.at == source_->size() ? End::kWhole : End::kDamaged;
    stop(end.whole ? of_whole : End::kCut);
    return {};
  }
  at_ = *next;
  return fail("end of the file", "more follows, from byte " + std::to_string(at_), true);
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
  if (!chunk || !(is_exactly(*chunk, record_.content) || search_.credible(at_))) {
    return fail("chunk", "its lengths contradict each other");
  }
  const std::uint64_t most = most_unpacked(at_);
  const std::uint64_t room = most - std::min(most, unpacked_bytes_);
  if (const auto done = unpack(*chunk, limits_, chunk_, room); !done) {
    unreadable_ = unreadable_ || !done.error().damaged;
    unpacked_bytes_ += std::min({chunk->uncompressed_size, room, kAnyRatioBytes});  // in vain
    return fail("chunk", done.error().why);
  }
  unpacked_bytes_ += chunk_.size();
  std::map<std::uint16_t, MessageIndex> messages_by_channel;
  if (auto done = judge_chunk(chunk->records.size(), messages_by_channel); !done) {
    chunk_.clear();
    return done;
  }
  index_check_.found(record_.offset);
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
    std::uint64_t packed_bytes, std::map<std::uint16_t, MessageIndex>& messages_by_channel) {
  std::uint64_t messages_left = most_messages(packed_bytes);
  for (std::size_t at = 0; at < chunk_.size();) {
    const std::optional<RecordAt> record = first_record(Bytes(chunk_).subspan(at));
    if (!record) {
      return fail("chunk", "a record in it is cut", true);
    }
    if (record->opcode == Opcode::kSchema || record->opcode == Opcode::kChannel) {
      if (!take_definition(record->opcode, record->content)) {
        unreadable_ = true;
        return fail("chunk", "a definition in it is cut, one of too many, or without its schema",
                    true);
      }
    } else if (record->opcode == Opcode::kMessage) {
      const std::optional<Message> message = parse_message(record->content);
      const std::optional<std::uint16_t> channel =
          message ? definitions_.channel(message->channel_id) : std::nullopt;
      if (!channel) {
        unreadable_ = true;
        return fail("chunk", "a message in it is cut, or of a channel that is not there", true);
      }
      if (messages_left-- == 0) {
        unreadable_ = true;
        return fail("chunk", "it holds more messages than its bytes can", true);
      }
      MessageIndex& messages = messages_by_channel[*channel];
      messages.channel_id = *channel;
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
    if (std::optional<Message> message = parse_message(record->content)) {
      message->channel_id = definitions_.channel(message->channel_id).value_or(0);
      return Item(*message);
    }
  }
  return std::optional<Item>();
}

bool StreamReader::take_definition(Opcode opcode, Bytes content) {
  if (opcode == Opcode::kSchema) {
    std::optional<Schema> schema = parse_schema(content);
    return schema && definitions_.take(std::move(*schema), index_, limits_);
  }
  std::optional<Channel> channel = parse_channel(content);
  return channel && definitions_.take(std::move(*channel), index_, limits_);
}

// A message index of the chunk before, if it says what was counted from the messages.
std::optional<std::uint16_t> StreamReader::indexed_channel(Bytes content) const {
  std::optional<MessageIndex> messages = chunk_sound_ ? parse_message_index(content) : std::nullopt;
  const std::optional<std::uint16_t> channel =
      messages ? definitions_.channel(messages->channel_id) : std::nullopt;
  const auto counted = channel ? chunk_messages_.find(*channel) : chunk_messages_.end();
  if (counted == chunk_messages_.end()) {
    return std::nullopt;
  }
  const auto by_offset = [](MessageIndex& one) {
    std::ranges::sort(one.entries, {}, &IndexEntry::offset);
  };
  by_offset(*messages);  // others may sort by time; counted are those of a chunk in its order
  const bool same = counted->second.entries == messages->entries;
  return same ? channel : std::nullopt;
}

std::expected<void, Problem> StreamReader::take_message_index() {
  if (!fields_fill(Opcode::kMessageIndex, record_.content)) {
    return fail("message index", "it is cut");
  }
  const std::optional<std::uint16_t> channel = indexed_channel(record_.content);
  const std::optional<MessageIndex> messages = parse_message_index(record_.content);
  if (!channel && chunk_sound_ && messages && !messages->entries.empty()) {
    return fail("message index", "it names other messages than its chunk holds", true);
  }
  index_check_.found_message_index(record_.offset);
  if (!channel) {
    return {};  // empty, or of a damaged chunk
  }
  ChunkIndex& chunk = index_.chunks.back();
  chunk.message_index_offsets[*channel] = record_.offset;
  chunk.message_index_length += record_.length;
  return {};
}

}  // namespace stof::mcap
