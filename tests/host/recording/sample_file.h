#pragma once

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/recording/mcap/reader.h"
#include "host/recording/mcap/writer.h"
#include "tests/host/recording/memory_sink.h"

namespace stof::test {

// A message with bytes of its own.
struct Sample {
  std::string topic{};
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  mcap::Buffer data{};
  friend bool operator==(const Sample&, const Sample&) = default;
};
using Samples = std::vector<Sample>;

// Messages of two topics, their times mostly in order; the same for each seed.
inline Samples samples(std::size_t count, std::uint32_t seed = 1) {
  std::mt19937 random(seed);  // NOLINT: the same numbers in each run
  Samples result;
  for (std::size_t k = 0; k < count; ++k) {
    Sample one{.topic = k % 3 == 2 ? "/other" : "/one",
               .sequence = static_cast<std::uint32_t>(k),
               .log_time = 1'000'000 * (k + 10) + random() % 2'000'000};
    one.data.resize(random() % 400);
    for (std::byte& byte : one.data) {
      byte = static_cast<std::byte>(random() % 7);
    }
    result.push_back(std::move(one));
  }
  return result;
}

// Writes samples, with channels made when they are needed.
class SampleWriter {
 public:
  explicit SampleWriter(mcap::Writer& writer) : writer_(writer) {}
  std::expected<void, mcap::Problem> add(const Sample& sample) {
    if (!ids_.contains(sample.topic)) {
      const auto id = writer_.add_channel(
          sample.topic, "cdr", {.name = "a/msg/B", .encoding = "ros2msg", .data = "uint8 x\n"},
          {{"unit", "none"}});
      if (!id) {
        return std::unexpected(id.error());
      }
      ids_[sample.topic] = *id;
    }
    return writer_.add_message({.channel_id = ids_[sample.topic],
                                .sequence = sample.sequence,
                                .log_time = sample.log_time,
                                .publish_time = sample.log_time,
                                .data = sample.data});
  }

 private:
  mcap::Writer& writer_;
  std::map<std::string, std::uint16_t> ids_;
};

// A whole file of them with one attachment and one metadata record; chunks of about 2 KiB.
inline mcap::Buffer sample_file(const Samples& all) {
  MemorySink sink;
  auto writer = mcap::Writer::begin(sink, {.library = "test", .chunk_bytes = 2048});
  EXPECT_TRUE(writer.has_value());
  SampleWriter to(*writer);
  EXPECT_TRUE(writer->add_metadata({.name = "stof", .entries = {{"a", "b"}, {"c", ""}}}));
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_TRUE(to.add(all[k]));
    if (k == all.size() / 2) {
      EXPECT_TRUE(writer->add_attachment({.log_time = 5,
                                          .create_time = 6,
                                          .name = "settings.json",
                                          .media_type = "application/json",
                                          .data = mcap::bytes_of("{}")}));
    }
  }
  EXPECT_TRUE(writer->finish());
  return sink.file;
}

inline Sample sample_of(const mcap::FileIndex& index, const mcap::Message& message) {
  return {.topic = index.channels.at(message.channel_id).topic,
          .sequence = message.sequence,
          .log_time = message.log_time,
          .data = {message.data.begin(), message.data.end()}};
}

struct Streamed {
  Samples messages{};
  std::size_t attachments = 0;
  std::size_t metadata = 0;
  std::size_t problems = 0;
  mcap::StreamReader::End end = mcap::StreamReader::End::kNotYet;
  std::uint64_t whole_until = 0;
};

inline Streamed stream(const mcap::ByteSource& source, const mcap::Limits& limits = {}) {
  Streamed result;
  auto reader = mcap::StreamReader::open(source, limits);
  if (!reader) {
    ++result.problems;
    return result;
  }
  while (true) {
    const auto item = reader->next();
    if (!item) {
      EXPECT_EQ(std::ranges::count(item.error().message, '\n'), 0);
      ++result.problems;
      continue;
    }
    if (!*item) {
      break;
    }
    if (const auto* const message = std::get_if<mcap::Message>(&**item)) {
      result.messages.push_back(sample_of(reader->index(), *message));
    } else if (std::holds_alternative<mcap::Attachment>(**item)) {
      ++result.attachments;
    } else {
      ++result.metadata;
    }
  }
  result.end = reader->end();
  result.whole_until = reader->whole_until();
  return result;
}
inline Streamed stream(const mcap::Buffer& file) { return stream(mcap::MemorySource(file)); }

// In the order of the sequence. Empty where the file has no index.
inline std::optional<Samples> by_index(const mcap::ByteSource& source,
                                       const std::string& topic = "") {
  auto reader = mcap::IndexedReader::open(source);
  if (!reader) {
    return std::nullopt;
  }
  if (!topic.empty()) {
    std::set<std::uint16_t> ids;
    for (const auto& [id, channel] : reader->index().channels) {
      if (channel.topic == topic) {
        ids.insert(id);
      }
    }
    reader->choose(ids);
  }
  Samples result;
  while (true) {
    const auto message = reader->next();
    if (!message) {
      ADD_FAILURE() << message.error().message;
      break;
    }
    if (!*message) {
      break;
    }
    result.push_back(sample_of(reader->index(), **message));
  }
  EXPECT_EQ(reader->index().statistics.message_count >= result.size(), true);
  std::ranges::sort(result, {}, &Sample::sequence);
  return result;
}
inline std::optional<Samples> by_index(const mcap::Buffer& file, const std::string& topic = "") {
  return by_index(mcap::MemorySource(file), topic);
}

inline bool is_prefix(const Samples& part, const Samples& all) {
  return part.size() <= all.size() && std::equal(part.begin(), part.end(), all.begin());
}

}  // namespace stof::test
