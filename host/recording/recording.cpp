#include "host/recording/recording.h"

#include <algorithm>

#include "firmware/wire/calibration/calibration_packet.h"

namespace stof::recording {
namespace {

using mcap::StreamReader;

// Counts frames and gaps.
class Counter {
 public:
  explicit Counter(Summary& summary) : summary_(summary) {}

  void take(const mcap::FileIndex& index, const mcap::Message& message) {
    if (!topics_.contains(message.channel_id)) {
      topics_[message.channel_id] = topic_of(index, message.channel_id);
    }
    const std::optional<Topic> topic = topics_[message.channel_id];
    if (topic != Topic::kFrameInfo && topic != Topic::kCalibration) {
      return;
    }
    const std::optional<Packet> packet = decode_packet(message.data);
    if (!packet) {
      ++summary_.damaged;
    } else if (topic == Topic::kCalibration) {
      if (const auto calibration = wire::read_calibration_packet(packet->payload)) {
        // What takes one back says nothing new.
        summary_.calibration = calibration->fingerprint == 0 && summary_.calibration
                                   ? summary_.calibration
                                   : std::optional(*calibration);
        lenses_.take(*calibration);
        summary_.lenses_contradict = lenses_.contradict();
      }
    } else {
      count(message.log_time, *packet);
    }
  }

 private:
  void count(std::uint64_t log_time, const Packet& packet) {
    constexpr std::uint32_t kBackwards = std::uint32_t{1} << 31;  // the same frames again
    Summary& all = summary_;
    ++all.frames;
    all.incomplete_frames += packet.missing_packets != 0 ? 1U : 0U;
    const bool same = before_ && before_->session_id == packet.origin.session_id &&
                      before_->device_id == packet.origin.device_id;
    if (!same) {
      ++all.sessions;
    } else if (const std::uint32_t step = packet.stamp.number - number_;
               step > 1 && step < kBackwards) {
      all.frames_missing += step - 1;
      if (all.gaps.size() < Summary::kMostGaps) {
        all.gaps.push_back({.after = number_, .frames = step - 1, .log_time = log_time});
      }
    }
    before_ = packet.origin;
    number_ = packet.stamp.number;
  }

  Summary& summary_;
  ToldLenses lenses_;
  std::map<std::uint16_t, std::optional<Topic>> topics_;
  std::optional<wire::Origin> before_;
  std::uint32_t number_ = 0;
};

void read_in_order(StreamReader& reader, const mcap::Progress& progress, Summary& summary) {
  Counter counter(summary);
  while (true) {
    if (progress) {
      progress(reader.position(), summary.bytes);
    }
    auto item = reader.next();
    if (!item) {
      ++summary.damaged;
      continue;
    }
    if (!*item) {
      break;
    }
    if (const auto* const message = std::get_if<mcap::Message>(&**item)) {
      counter.take(reader.index(), *message);
    } else if (auto* const metadata = std::get_if<mcap::Metadata>(&**item)) {
      if (metadata->name == kSensorMetadata) {
        summary.sensor = std::move(metadata->entries);
      }
    }
  }
  summary.index = reader.index();
  summary.state.end = reader.end();
  summary.state.indexed = reader.indexed();
  summary.state.files = reader.files();
  summary.damaged_bytes = reader.damaged_bytes();
  if (summary.state.end != StreamReader::End::kWhole) {
    summary.whole_bytes = reader.whole_until();
  }
}

std::unexpected<Problem> in_file(const std::filesystem::path& file, const Problem& problem) {
  return std::unexpected(Problem{file.string() + ": " + problem.message});
}

}  // namespace

std::optional<Topic> topic_of(const mcap::FileIndex& index, std::uint16_t id) {
  const auto channel = index.channels.find(id);
  if (channel == index.channels.end()) {
    return std::nullopt;
  }
  const auto schema = index.schemas.find(channel->second.schema_id);
  const std::optional<Topic> topic = topic_named(channel->second.topic);
  const bool ours = topic && schema != index.schemas.end() &&
                    channel->second.message_encoding == kEncoding &&
                    schema->second.name == info_of(*topic).schema().name;
  return ours ? topic : std::nullopt;
}

std::expected<Summary, Problem> summarise(const std::filesystem::path& file,
                                          const mcap::Progress& progress) {
  auto source = mcap::FileSource::open(file);
  if (!source) {
    return std::unexpected(source.error());
  }
  Summary summary{.bytes = source->size(), .whole_bytes = source->size()};
  auto reader = StreamReader::open(*source);
  if (!reader) {
    return in_file(file, reader.error());
  }
  summary.state.being_written = source->is_locked();
  read_in_order(*reader, progress, summary);
  return summary;
}

std::expected<FrameReader, Problem> FrameReader::open(const std::filesystem::path& file) {
  auto source = mcap::FileSource::open(file);
  if (!source) {
    return std::unexpected(source.error());
  }
  auto kept = std::make_unique<mcap::FileSource>(std::move(*source));
  auto reader = StreamReader::open(*kept);
  if (!reader) {
    return in_file(file, reader.error());
  }
  return FrameReader(std::move(kept), std::move(*reader));
}

std::optional<RecordedFrame> FrameReader::of_its_file(std::optional<RecordedFrame> frame) const {
  if (frame) {
    frame->file = file_;
  }
  return frame;
}

std::optional<RecordedFrame> FrameReader::next() {
  while (true) {
    const auto item = reader_.next();
    if (!item) {
      ++damaged_;
      continue;
    }
    if (!*item) {
      return of_its_file(frames_.end());
    }
    if (const auto* const metadata = std::get_if<mcap::Metadata>(&**item)) {
      forged_traffic_ = forged_traffic_ || (metadata->name == kSensorMetadata &&
                                            metadata->entries.contains(kForgedTraffic));
    }
    const auto* const message = std::get_if<mcap::Message>(&**item);
    const std::optional<Topic> topic =
        message != nullptr ? topic_of(reader_.index(), message->channel_id) : std::nullopt;
    if (topic) {
      auto frame = of_its_file(frames_.take(*topic, *message));
      if (topic == Topic::kFrameInfo) {  // with which the next frame begins
        file_ = reader_.files();
      }
      if (frame) {
        return frame;
      }
    }
  }
}

FileState FrameReader::state() const noexcept {
  return {.indexed = reader_.indexed(),
          .end = reader_.end(),
          .being_written = being_written_,
          .files = reader_.files()};
}

}  // namespace stof::recording
