#include "host/recording/mcap/recover.h"

#include <algorithm>

#include "dataset/files/file.h"
#include "host/recording/mcap/record_bytes.h"
#include "host/recording/mcap/writer.h"

namespace stof::mcap {
namespace {

std::unexpected<Problem> in_file(const std::filesystem::path& file, const Problem& problem) {
  return std::unexpected(Problem{file.string() + ": " + problem.message});
}

void tell(const Progress& progress, const StreamReader& reader, const ByteSource& source) {
  if (progress) {
    progress(reader.position(), source.size());
  }
}

// Of the first `size` bytes.
std::expected<Crc32, Problem> crc_of(const ByteSource& source, std::uint64_t size) {
  constexpr std::uint64_t kPiece = std::uint64_t{1} << 20;
  Crc32 crc;
  Buffer piece;
  for (std::uint64_t at = 0; at < size; at += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min(kPiece, size - at)));
    if (!source.read(at, piece)) {
      return std::unexpected(Problem{"cannot be read: check the disk"});
    }
    crc.add(piece);
  }
  return crc;
}

// Begin of the damaged records at the end of the file, if there are any: a power cut may leave what
// was not flushed. A problem: something sound follows them.
std::expected<std::optional<std::uint64_t>, Problem> read_to_end(
    StreamReader& reader, const std::function<void()>& tell) {
  std::optional<std::uint64_t> first_damaged;
  std::string what;
  while (true) {
    tell();
    const auto item = reader.next();
    if (!item) {
      first_damaged =
          std::min(reader.record_offset(), first_damaged.value_or(reader.record_offset()));
      what = what.empty() ? item.error().message : what;
    } else if (!*item && reader.can_index_in_place()) {
      return first_damaged;
    } else if (!*item && !first_damaged) {
      return std::unexpected(
          Problem{"ids in it mean two things, or its end cannot be judged: give "
                  "OUT, a file that gets what is sound"});
    } else if (first_damaged) {
      return std::unexpected(Problem{what + ": give OUT, a file that gets what is sound"});
    }
  }
}

// What is missing behind the last chunk of its message indexes; `end` is where it belongs then.
Buffer index_last_chunk(const StreamReader& reader, FileIndex& index, std::uint64_t& end) {
  Buffer missing;
  const auto& messages = reader.chunk_messages();
  if (index.chunks.empty() || index.chunks.back().message_index_offsets.size() == messages.size()) {
    return missing;
  }
  ChunkIndex& last = index.chunks.back();
  end = last.chunk_offset + last.chunk_length;
  last.message_index_offsets.clear();
  for (const auto& [channel, one] : messages) {
    last.message_index_offsets[channel] = end + missing.size();
    append(missing, one);
  }
  last.message_index_length = missing.size();
  return missing;
}

}  // namespace

std::expected<Recovered, Problem> recover(const std::filesystem::path& file,
                                          const Progress& progress) {
  auto source = FileSource::open(file);
  if (!source) {
    return std::unexpected(source.error());
  }
  auto reader = StreamReader::open(*source);
  if (!reader) {
    return in_file(file, reader.error());
  }
  if (auto done = source->lock(file); !done) {
    return std::unexpected(done.error());
  }
  const auto damage = read_to_end(*reader, [&] { tell(progress, *reader, *source); });
  if (!damage) {
    return in_file(file, damage.error());
  }
  const std::optional<std::uint64_t> first_damaged = *damage;
  Recovered result{.messages = reader->index().statistics.message_count,
                   .damaged = first_damaged ? 1U : 0U,
                   .damaged_bytes = reader->damaged_bytes()};
  if (!first_damaged && reader->end() == StreamReader::End::kWhole && reader->indexed()) {
    result.was_whole = true;
    return result;
  }
  if (!reader->chunked() || !reader->earlier_chunks_indexed()) {
    return in_file(file, Problem{"has messages that no index in it finds: give OUT, a file that "
                                 "gets them with one"});
  }
  FileIndex index = reader->index();
  std::uint64_t end = first_damaged.value_or(reader->whole_until());
  const Buffer missing = index_last_chunk(*reader, index, end);
  result.cut_bytes = source->size() - end;
  auto crc = crc_of(*source, end);
  if (!crc) {
    return in_file(file, crc.error());
  }
  auto sink = FileSink::open(file, FileSink::Existing::kAppend);
  if (!sink) {
    return std::unexpected(sink.error());
  }
  crc->add(missing);
  auto done = then(sink->cut_to(end), [&] { return sink->write(missing); });
  done = then(done, [&] {
    return Writer::resume(*sink, {}, std::move(index), end + missing.size(), *crc).finish();
  });
  if (!done) {
    static_cast<void>(sink->cut_to(end));  // no half of an index
    return std::unexpected(done.error());
  }
  return result;
}

namespace {

// Copies items, and channels as they are needed.
class Copy {
 public:
  Copy(const StreamReader& from, Writer& to) : from_(from), to_(to) {}

  std::expected<void, Problem> take(const Item& item) {
    if (const auto* const attachment = std::get_if<Attachment>(&item)) {
      return to_.add_attachment(*attachment);
    }
    if (const auto* const metadata = std::get_if<Metadata>(&item)) {
      return to_.add_metadata(*metadata);
    }
    Message message = std::get<Message>(item);
    const auto id = channel(message.channel_id);
    if (!id) {
      return std::unexpected(id.error());
    }
    message.channel_id = *id;
    return to_.add_message(message);
  }

 private:
  std::expected<std::uint16_t, Problem> channel(std::uint16_t id) {
    // Ids of a reader stand for one channel for ever.
    if (const auto known = ids_.find(id); known != ids_.end()) {
      return known->second;
    }
    const Channel& channel = from_.index().channels.at(id);
    const auto schema = from_.index().schemas.find(channel.schema_id);
    auto added = to_.add_channel(channel.topic, channel.message_encoding,
                                 schema == from_.index().schemas.end() ? Schema{} : schema->second,
                                 channel.metadata);
    if (added) {
      ids_[id] = *added;
    }
    return added;
  }

  const StreamReader& from_;
  Writer& to_;
  std::map<std::uint16_t, std::uint16_t> ids_;
};

}  // namespace

std::expected<Recovered, Problem> recover(const std::filesystem::path& file,
                                          const std::filesystem::path& out,
                                          FileSink::Existing existing, const Progress& progress) {
  std::error_code none;
  if (std::filesystem::equivalent(file, out, none)) {
    return dataset::refuse(out, "is the recording itself", "leave OUT away, or give another name");
  }
  auto source = FileSource::open(file);
  if (!source) {
    return std::unexpected(source.error());
  }
  auto reader = StreamReader::open(*source);
  if (!reader) {
    return in_file(file, reader.error());
  }
  auto sink = FileSink::open(out, existing);
  if (!sink) {
    return std::unexpected(sink.error());
  }
  // No part of a copy is left: all of it is in `file` still.
  const auto drop = [&](const Problem& problem) {
    std::filesystem::remove(out, none);
    return std::unexpected(problem);
  };
  auto writer = Writer::begin(
      *sink, {.profile = reader->header().profile, .library = reader->header().library});
  if (!writer) {
    return drop(writer.error());
  }
  Recovered result;
  Copy copy(*reader, *writer);
  while (true) {
    tell(progress, *reader, *source);
    const auto item = reader->next();
    if (!item) {
      ++result.damaged;
      continue;
    }
    if (!*item) {
      break;
    }
    if (auto done = copy.take(**item); !done) {
      return drop(done.error());
    }
  }
  result.damaged_bytes = reader->damaged_bytes();
  result.cut_bytes =
      reader->end() == StreamReader::End::kWhole ? 0 : source->size() - reader->whole_until();
  if (auto done = writer->finish(); !done) {
    return drop(done.error());
  }
  result.messages = writer->index().statistics.message_count;
  result.files = reader->files();
  return result;
}

}  // namespace stof::mcap
