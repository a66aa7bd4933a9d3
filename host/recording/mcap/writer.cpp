#include "host/recording/mcap/writer.h"

#include <algorithm>
#include <utility>

#include "host/recording/mcap/record_bytes.h"

namespace stof::mcap {
namespace {

constexpr std::size_t kMostMarks = 8;

}  // namespace

Writer::Writer(ByteSink& sink, const WriterOptions& options)
    : sink_(&sink), options_(options), compressor_(options.zstd_level) {}

std::expected<Writer, Problem> Writer::begin(ByteSink& sink, const WriterOptions& options) {
  Writer writer(sink, options);
  append_bytes(writer.out_, std::as_bytes(std::span(kMagic)));
  append(writer.out_, Header{.profile = options.profile, .library = options.library});
  if (auto done = then(writer.put(writer.out_), [&] { return sink.sync(); }); !done) {
    return std::unexpected(done.error());
  }
  return writer;
}

Writer Writer::resume(ByteSink& sink, const WriterOptions& options, FileIndex index,
                      std::uint64_t position, const Crc32& data_crc) {
  Writer writer(sink, options);
  writer.index_ = std::move(index);
  writer.position_ = position;
  writer.data_crc_ = data_crc;
  return writer;
}

std::expected<void, Problem> Writer::put(Bytes bytes) {
  if (auto done = sink_->write(bytes); !done) {
    return done;
  }
  data_crc_.add(bytes);
  position_ += bytes.size();
  return {};
}

std::expected<std::uint16_t, Problem> Writer::add_channel(std::string_view topic,
                                                          std::string_view message_encoding,
                                                          const Schema& schema,
                                                          const TextMap& metadata) {
  out_.clear();
  auto known = std::ranges::find_if(
      index_.schemas, [&](const auto& one) { return one.second.name == schema.name; });
  if (known == index_.schemas.end() && !schema.name.empty()) {
    Schema added = schema;
    added.id = static_cast<std::uint16_t>(index_.schemas.size() + 1);
    append(out_, added);
    known = index_.schemas.emplace(added.id, std::move(added)).first;
  }
  Channel channel{.id = static_cast<std::uint16_t>(index_.channels.size() + 1),
                  .schema_id = known == index_.schemas.end() ? std::uint16_t{0} : known->first,
                  .topic = std::string(topic),
                  .message_encoding = std::string(message_encoding),
                  .metadata = metadata};
  append(out_, channel);
  if (auto done = put(out_); !done) {
    return std::unexpected(done.error());
  }
  const std::uint16_t id = channel.id;
  index_.channels.emplace(id, std::move(channel));
  return id;
}

std::expected<void, Problem> Writer::add_message(const Message& message) {
  const std::uint64_t time = message.log_time;
  chunk_start_ = chunk_.empty() ? time : std::min(chunk_start_, time);
  chunk_end_ = chunk_.empty() ? time : std::max(chunk_end_, time);
  MessageIndex& index = chunk_index_[message.channel_id];
  index.channel_id = message.channel_id;
  index.entries.push_back({.log_time = time, .offset = chunk_.size()});
  append(chunk_, message);
  return chunk_.size() < options_.chunk_bytes ? std::expected<void, Problem>() : write_chunk();
}

std::expected<void, Problem> Writer::write_chunk() {
  if (chunk_.empty()) {
    return {};
  }
  Mark mark{.position = position_, .data_crc = data_crc_};
  Buffer compressed;
  compressor_.compress(chunk_, compressed);
  out_.clear();
  append(out_, Chunk{.start_time = chunk_start_,
                     .end_time = chunk_end_,
                     .uncompressed_size = chunk_.size(),
                     .uncompressed_crc = crc32(chunk_),
                     .compression = "zstd",
                     .records = compressed});
  ChunkIndex index{.start_time = chunk_start_,
                   .end_time = chunk_end_,
                   .chunk_offset = position_,
                   .chunk_length = out_.size(),
                   .compression = "zstd",
                   .compressed_size = compressed.size(),
                   .uncompressed_size = chunk_.size()};
  for (const auto& [channel, messages] : chunk_index_) {
    index.message_index_offsets[channel] = position_ + out_.size();
    append(out_, messages);
  }
  index.message_index_length = out_.size() - index.chunk_length;
  if (auto done = put(out_); !done) {
    return done;
  }
  for (const auto& [channel, messages] : chunk_index_) {
    mark.messages[channel] = messages.entries.size();
    for (const IndexEntry& entry : messages.entries) {
      index_.count_message(channel, entry.log_time);
    }
  }
  index_.chunks.push_back(std::move(index));
  ++index_.statistics.chunk_count;
  marks_.push_back(std::move(mark));
  if (marks_.size() > kMostMarks) {
    marks_.pop_front();
  }
  chunk_.clear();
  chunk_index_.clear();
  return {};
}

std::expected<void, Problem> Writer::add_attachment(const Attachment& attachment) {
  out_.clear();
  append(out_, attachment);
  AttachmentIndex index{.offset = position_,
                        .length = out_.size(),
                        .log_time = attachment.log_time,
                        .create_time = attachment.create_time,
                        .data_size = attachment.data.size(),
                        .name = attachment.name,
                        .media_type = attachment.media_type};
  if (auto done = put(out_); !done) {
    return done;
  }
  index_.attachments.push_back(std::move(index));
  ++index_.statistics.attachment_count;
  return {};
}

std::expected<void, Problem> Writer::add_metadata(const Metadata& metadata) {
  out_.clear();
  append(out_, metadata);
  MetadataIndex index{.offset = position_, .length = out_.size(), .name = metadata.name};
  if (auto done = put(out_); !done) {
    return done;
  }
  index_.metadata.push_back(std::move(index));
  ++index_.statistics.metadata_count;
  return {};
}

std::expected<void, Problem> Writer::flush() {
  return then(write_chunk(), [this] { return sink_->sync(); });
}

std::expected<void, Problem> Writer::write_end() {
  Buffer end;
  append_summary(end, index_, position_, data_crc_.value());
  end_bytes_ = end.size();
  return then(sink_->write(end), [this] { return sink_->sync(); });
}

std::expected<void, Problem> Writer::finish() {
  return then(write_chunk(), [this] { return write_end(); });
}

void Writer::return_to(const Mark& mark) {
  position_ = mark.position;
  data_crc_ = mark.data_crc;
  const auto behind = [&](const auto& one) { return one.offset >= mark.position; };
  std::erase_if(index_.attachments, behind);
  std::erase_if(index_.metadata, behind);
  index_.chunks.pop_back();
  Statistics& all = index_.statistics;
  all.attachment_count = static_cast<std::uint32_t>(index_.attachments.size());
  all.metadata_count = static_cast<std::uint32_t>(index_.metadata.size());
  all.chunk_count = static_cast<std::uint32_t>(index_.chunks.size());
  for (const auto& [channel, messages] : mark.messages) {
    all.message_count -= messages;
    all.messages_by_channel[channel] -= messages;
  }
  all.start_time = 0;
  all.end_time = 0;
  for (const ChunkIndex& chunk : index_.chunks) {
    const bool first = &chunk == &index_.chunks.front();
    all.start_time = first ? chunk.start_time : std::min(all.start_time, chunk.start_time);
    all.end_time = std::max(all.end_time, chunk.end_time);
  }
}

bool Writer::rescue() {
  while (true) {
    if (!sink_->cut_to(position_)) {
      return false;
    }
    if (write_end()) {
      return true;
    }
    if (marks_.empty()) {
      static_cast<void>(sink_->cut_to(position_));
      return false;
    }
    return_to(marks_.back());
    marks_.pop_back();
  }
}

}  // namespace stof::mcap
