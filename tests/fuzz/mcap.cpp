#include <string>

#include "host/recording/mcap/reader.h"
#include "host/recording/mcap/record_bytes.h"
#include "host/recording/ros_messages.h"
#include "tests/fuzz/fuzz_input.h"

// Recordings from anywhere: any bytes, read from begin to end and by index, and their messages.
// The first byte of the input says how; kRecords: records follow each other without a file around
// them, which is put there, so that what lies behind magic and CRCs is reached as well.
namespace stof {
namespace {

constexpr unsigned kRecords = 1;
constexpr unsigned kInChunk = 2;
constexpr mcap::Limits kSmall{.record_bytes = 1 << 16, .chunk_bytes = 1 << 16, .channels = 8};

void judge(const mcap::Problem& problem) {
  fuzz::require(!problem.message.empty());
  fuzz::require(problem.message.find('\n') == std::string::npos);
}

void look_at(const mcap::Message& message) {
  if (const auto image = recording::decode_image(message.data)) {
    const std::size_t bytes = image->encoding == "16UC1" ? 2 : 1;
    fuzz::require(image->data.size() == bytes * image->width * image->height);
  }
  if (const auto packet = recording::decode_packet(message.data)) {
    fuzz::require(packet->payload.size() <= message.data.size());
  }
}

void read_in_order(const mcap::ByteSource& source) {
  auto reader = mcap::StreamReader::open(source, kSmall);
  if (!reader) {
    judge(reader.error());
    return;
  }
  std::uint64_t messages = 0;
  while (true) {
    const auto item = reader->next();
    if (!item) {
      judge(item.error());
      continue;
    }
    if (!*item) {
      break;
    }
    if (const auto* const message = std::get_if<mcap::Message>(&**item)) {
      fuzz::require(reader->index().channels.contains(message->channel_id));
      ++messages;
      look_at(*message);
    }
  }
  fuzz::require(reader->end() != mcap::StreamReader::End::kNotYet);
  fuzz::require(reader->whole_until() <= source.size());
  fuzz::require(reader->damaged_bytes() <= source.size());
  fuzz::require(reader->index().statistics.message_count == messages);
  fuzz::require(reader->index().channels.size() <= kSmall.channels);
}

void read_by_index(const mcap::ByteSource& source) {
  auto reader = mcap::IndexedReader::open(source, kSmall);
  if (!reader) {
    judge(reader.error());
    return;
  }
  constexpr int kMost = 1000;  // an index may name one message any number of times
  for (int k = 0; k < kMost; ++k) {
    const auto message = reader->next();
    if (!message) {
      judge(message.error());
    } else if (!*message) {
      break;
    } else {
      look_at(**message);
    }
  }
  const mcap::FileIndex index = reader->index();
  for (const mcap::AttachmentIndex& one : index.attachments) {
    if (const auto attachment = reader->attachment(one); !attachment) {
      judge(attachment.error());
    }
  }
  for (const mcap::MetadataIndex& one : index.metadata) {
    if (const auto metadata = reader->metadata(one); !metadata) {
      judge(metadata.error());
    }
  }
}

// A file around records; those are its data section, and the summary too.
mcap::Buffer file_around(mcap::Bytes records, bool in_chunk) {
  mcap::Buffer file;
  mcap::append_bytes(file, std::as_bytes(std::span(mcap::kMagic)));
  append(file, mcap::Header{});
  append(file, mcap::Schema{.id = 1, .name = "a"});
  append(file, mcap::Channel{.id = 1, .schema_id = 1, .topic = "/a"});
  if (in_chunk) {
    append(file, mcap::Chunk{.uncompressed_size = records.size(), .records = records});
  } else {
    mcap::append_bytes(file, records);
  }
  mcap::append_data_end(file, 0);
  const std::uint64_t summary = file.size();
  append(file, mcap::Channel{.id = 1, .topic = "/a"});
  mcap::append_bytes(file, records);
  append(file, mcap::Footer{.summary_start = summary});
  mcap::append_bytes(file, std::as_bytes(std::span(mcap::kMagic)));
  return file;
}

}  // namespace
}  // namespace stof

void stof::fuzz::run(std::span<const std::byte> input) {
  if (input.empty()) {
    return;
  }
  const auto how = std::to_integer<unsigned>(input[0]);
  const mcap::Bytes rest = input.subspan(1);
  const mcap::Buffer file = (how & kRecords) != 0 ? file_around(rest, (how & kInChunk) != 0)
                                                  : mcap::Buffer(rest.begin(), rest.end());
  const mcap::MemorySource source(file);
  read_in_order(source);
  read_by_index(source);
}
