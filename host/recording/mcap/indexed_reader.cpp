#include "host/recording/mcap/indexed_reader.h"

#include <algorithm>

#include "host/recording/mcap/chunk.h"
#include "host/recording/mcap/crc32.h"
#include "host/recording/mcap/record_bytes.h"

namespace stof::mcap {
namespace {

constexpr std::size_t kEnd = kRecordHead + kFooterContent + kMagic.size();

std::unexpected<Problem> no_index() {
  return std::unexpected(Problem{"has no whole index: stof recover FILE makes it anew"});
}

std::optional<Message> message_at(Bytes chunk, std::uint64_t offset) {
  const std::optional<RecordAt> record =
      offset < chunk.size() ? first_record(chunk.subspan(static_cast<std::size_t>(offset)))
                            : std::nullopt;
  return record && record->opcode == Opcode::kMessage ? parse_message(record->content)
                                                      : std::nullopt;
}

}  // namespace

std::expected<IndexedReader, Problem> IndexedReader::open(const ByteSource& source,
                                                          const Limits& limits) {
  IndexedReader reader(source, limits);
  std::array<std::byte, kMagic.size()> magic{};
  const auto is_magic = [&] { return std::ranges::equal(magic, std::as_bytes(std::span(kMagic))); };
  if (!source.read(0, magic) || !is_magic()) {
    return std::unexpected(Problem{"is not an MCAP file: give a recording"});
  }
  if (source.size() < magic.size() + kEnd || !source.read(source.size() - magic.size(), magic) ||
      !is_magic()) {
    return no_index();
  }
  if (auto done = reader.read_summary(); !done) {
    return std::unexpected(done.error());
  }
  return reader;
}

std::expected<void, Problem> IndexedReader::read_summary() {
  const std::uint64_t footer_at = source_->size() - kEnd;
  std::array<std::byte, kRecordHead + kFooterContent> bytes{};
  if (!source_->read(footer_at, bytes)) {
    return no_index();
  }
  const std::optional<RecordAt> record = first_record(bytes);
  const std::optional<Footer> footer =
      record && record->opcode == Opcode::kFooter ? parse_footer(record->content) : std::nullopt;
  if (!footer || footer->summary_start < kMagic.size() || footer->summary_start > footer_at ||
      footer_at - footer->summary_start > limits_.record_bytes) {
    return no_index();
  }
  constexpr std::size_t kCrc = 4;
  Buffer summary(static_cast<std::size_t>(footer_at - footer->summary_start) + bytes.size() - kCrc);
  if (!source_->read(footer->summary_start, summary) ||
      (footer->summary_crc != 0 && crc32(summary) != footer->summary_crc)) {
    return damaged("index", footer->summary_start,
                   "its CRC is another one: stof recover FILE OUT makes it anew");
  }
  Bytes left = Bytes(summary).first(static_cast<std::size_t>(footer_at - footer->summary_start));
  std::uint64_t at = footer->summary_start;
  while (!left.empty()) {
    std::optional<RecordAt> one = first_record(left);
    if (!one) {
      return damaged("index", at, "a record of it is cut");
    }
    one->offset = at;
    if (auto done = take_summary_record(*one); !done) {
      return done;
    }
    left = left.subspan(static_cast<std::size_t>(one->length));
    at += one->length;
  }
  return {};
}

std::expected<void, Problem> IndexedReader::take_summary_record(const RecordAt& record) {
  const auto keep = [&](auto value, const auto& store) -> std::expected<void, Problem> {
    if (!value) {
      return damaged("index", record.offset, "a record of it is cut");
    }
    store(std::move(*value));
    return {};
  };
  switch (record.opcode) {
    case Opcode::kSchema:
      return keep(parse_schema(record.content),
                  [&](Schema&& one) { index_.schemas.insert_or_assign(one.id, std::move(one)); });
    case Opcode::kChannel:
      return keep(parse_channel(record.content),
                  [&](Channel&& one) { index_.channels.insert_or_assign(one.id, std::move(one)); });
    case Opcode::kChunkIndex:
      return keep(parse_chunk_index(record.content),
                  [&](ChunkIndex&& one) { index_.chunks.push_back(std::move(one)); });
    case Opcode::kAttachmentIndex:
      return keep(parse_attachment_index(record.content),
                  [&](AttachmentIndex&& one) { index_.attachments.push_back(std::move(one)); });
    case Opcode::kMetadataIndex:
      return keep(parse_metadata_index(record.content),
                  [&](MetadataIndex&& one) { index_.metadata.push_back(std::move(one)); });
    case Opcode::kStatistics:
      return keep(parse_statistics(record.content),
                  [&](Statistics&& one) { index_.statistics = std::move(one); });
    default:
      return {};  // summary offsets; what is of a newer writer
  }
}

void IndexedReader::choose(std::set<std::uint16_t> channels) {
  chosen_ = std::move(channels);
  next_chunk_ = 0;
  entries_.clear();
  next_entry_ = 0;
}

void IndexedReader::seek(std::uint64_t log_time) {
  const auto chunk = std::ranges::find_if(
      index_.chunks, [&](const ChunkIndex& one) { return one.end_time >= log_time; });
  next_chunk_ = static_cast<std::size_t>(chunk - index_.chunks.begin());
  entries_.clear();
  next_entry_ = 0;
}

std::optional<MessageIndex> IndexedReader::messages_of(const ChunkIndex& chunk,
                                                       std::uint16_t channel) {
  const auto at = chunk.message_index_offsets.find(channel);
  if (at == chunk.message_index_offsets.end()) {
    return std::nullopt;
  }
  const auto record = record_at(at->second, 0);
  return record && record->opcode == Opcode::kMessageIndex ? parse_message_index(record->content)
                                                           : std::nullopt;
}

std::optional<Message> IndexedReader::newest(std::uint16_t channel, std::uint64_t from,
                                             std::uint64_t until) {
  for (std::size_t i = index_.chunks.size(); i > 0; --i) {
    const ChunkIndex& chunk = index_.chunks[i - 1];
    if (chunk.start_time > until || chunk.end_time < from) {
      continue;
    }
    const std::optional<MessageIndex> messages = messages_of(chunk, channel);
    const IndexEntry* newest = nullptr;
    for (const IndexEntry& entry :
         messages ? std::span(messages->entries) : std::span<const IndexEntry>()) {
      if (entry.log_time >= from && entry.log_time <= until &&
          (newest == nullptr || entry.log_time >= newest->log_time)) {
        newest = &entry;
      }
    }
    if (newest != nullptr && open_chunk(chunk, beside_)) {
      const std::optional<Message> message = message_at(beside_, newest->offset);
      if (message && message->channel_id == channel) {
        return message;
      }
    }
  }
  return std::nullopt;
}

std::optional<std::uint64_t> IndexedReader::last_time(std::uint16_t channel) {
  for (std::size_t i = index_.chunks.size(); i > 0; --i) {
    const std::optional<MessageIndex> messages = messages_of(index_.chunks[i - 1], channel);
    if (messages && !messages->entries.empty()) {
      return std::ranges::max(messages->entries, {}, &IndexEntry::log_time).log_time;
    }
  }
  return std::nullopt;
}

std::vector<std::uint64_t> IndexedReader::times(std::uint16_t channel) {
  std::vector<std::uint64_t> all;
  for (const ChunkIndex& chunk : index_.chunks) {
    if (const std::optional<MessageIndex> messages = messages_of(chunk, channel)) {
      for (const IndexEntry& entry : messages->entries) {
        all.push_back(entry.log_time);
      }
    }
  }
  return all;
}

std::expected<std::optional<Message>, Problem> IndexedReader::next() {
  while (next_entry_ == entries_.size()) {
    entries_.clear();
    next_entry_ = 0;
    if (next_chunk_ == index_.chunks.size()) {
      return std::optional<Message>();
    }
    const ChunkIndex& chunk = index_.chunks[next_chunk_++];
    const bool any = std::ranges::any_of(chunk.message_index_offsets,
                                         [&](const auto& one) { return wanted(one.first); });
    if (!any) {
      continue;
    }
    const auto done = then(read_entries(chunk), [&] { return open_chunk(chunk, chunk_); });
    if (!done) {
      entries_.clear();
      return std::unexpected(done.error());
    }
  }
  const Entry& entry = entries_[next_entry_++];
  const std::optional<Message> message = message_at(chunk_, entry.message.offset);
  if (!message || message->channel_id != entry.channel ||
      !index_.channels.contains(entry.channel)) {
    next_entry_ = entries_.size();
    return damaged("chunk", index_.chunks[next_chunk_ - 1].chunk_offset,
                   "its index names what is no message of it");
  }
  return message;
}

std::expected<void, Problem> IndexedReader::read_entries(const ChunkIndex& chunk) {
  for (const auto& [channel, offset] : chunk.message_index_offsets) {
    if (!wanted(channel)) {
      continue;
    }
    const auto record = record_at(offset, 0);
    const std::optional<MessageIndex> messages = record && record->opcode == Opcode::kMessageIndex
                                                     ? parse_message_index(record->content)
                                                     : std::nullopt;
    if (!messages || messages->channel_id != channel) {
      return damaged("chunk", chunk.chunk_offset, "the index of its messages is not there");
    }
    for (const IndexEntry& entry : messages->entries) {
      entries_.push_back({.message = entry, .channel = channel});
    }
  }
  std::ranges::sort(entries_, {}, [](const Entry& entry) {
    return std::pair(entry.message.log_time, entry.message.offset);
  });
  return {};
}

std::expected<void, Problem> IndexedReader::open_chunk(const ChunkIndex& chunk, Buffer& unpacked) {
  const auto record = record_at(chunk.chunk_offset, chunk.chunk_length);
  if (!record) {
    return std::unexpected(record.error());
  }
  const std::optional<Chunk> packed =
      record->opcode == Opcode::kChunk ? parse_chunk(record->content) : std::nullopt;
  if (!packed) {
    return damaged("chunk", chunk.chunk_offset, "it is not where the index says");
  }
  if (const auto done = unpack(*packed, limits_, unpacked); !done) {
    return damaged("chunk", chunk.chunk_offset, done.error().why);
  }
  return {};
}

// length: of the whole record, as the index says; 0: it does not say.
std::expected<RecordAt, Problem> IndexedReader::record_at(std::uint64_t offset,
                                                          std::uint64_t length) {
  std::array<std::byte, kRecordHead> head{};
  if (!source_->read(offset, head)) {
    return damaged("index", offset, "it names what is not in the file");
  }
  Cursor from(head);
  RecordAt record{.opcode = static_cast<Opcode>(from.number<std::uint8_t>()), .offset = offset};
  const auto content = from.number<std::uint64_t>();
  if (content > limits_.record_bytes || content > source_->size() ||
      (length != 0 && content + kRecordHead != length)) {
    return damaged("record", offset, "its length is not what the index says");
  }
  buffer_.resize(static_cast<std::size_t>(content));
  if (!source_->read(offset + kRecordHead, buffer_)) {
    return damaged("record", offset, "it is cut");
  }
  record.length = kRecordHead + content;
  record.content = buffer_;
  return record;
}

std::expected<Attachment, Problem> IndexedReader::attachment(const AttachmentIndex& index) {
  const auto record = record_at(index.offset, index.length);
  if (!record) {
    return std::unexpected(record.error());
  }
  std::optional<Attachment> attachment =
      record->opcode == Opcode::kAttachment ? parse_attachment(record->content) : std::nullopt;
  if (!attachment) {
    return damaged("attachment", index.offset, "it is not there, or its CRC is another one");
  }
  return std::move(*attachment);
}

std::expected<Metadata, Problem> IndexedReader::metadata(const MetadataIndex& index) {
  const auto record = record_at(index.offset, index.length);
  if (!record) {
    return std::unexpected(record.error());
  }
  std::optional<Metadata> metadata =
      record->opcode == Opcode::kMetadata ? parse_metadata(record->content) : std::nullopt;
  if (!metadata) {
    return damaged("metadata", index.offset, "it is not there");
  }
  return std::move(*metadata);
}

}  // namespace stof::mcap
