#include "host/recording/indexed_frames.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "firmware/wire/calibration/calibration_packet.h"
#include "host/recording/recording.h"

namespace stof::recording {
namespace {

// What is looked through for the last frame that can be read, at first.
constexpr std::uint64_t kLookedThroughNs = 1'000'000'000;

bool lies_beside(Topic topic) { return topic == Topic::kCalibration || topic == Topic::kEvent; }

}  // namespace

IndexedFrames::IndexedFrames(std::unique_ptr<mcap::FileSource> source, mcap::IndexedReader&& reader)
    : source_(std::move(source)), reader_(std::move(reader)) {
  for (const auto& [id, channel] : reader_.index().channels) {
    if (const std::optional<Topic> topic = topic_of(reader_.index(), id)) {
      topics_[id] = *topic;
    }
  }
}

std::expected<IndexedFrames, Problem> IndexedFrames::open(const std::filesystem::path& file) {
  auto source = mcap::FileSource::open(file);
  if (!source) {
    return std::unexpected(source.error());
  }
  auto kept = std::make_unique<mcap::FileSource>(std::move(*source));
  auto reader = mcap::IndexedReader::open(*kept);
  if (!reader) {
    return std::unexpected(Problem{file.string() + ": " + reader.error().message});
  }
  IndexedFrames frames(std::move(kept), std::move(*reader));
  frames.read_beside();
  for (const auto& [id, topic] : frames.topics_) {
    if (topic == Topic::kFrameInfo) {
      frames.end_ns_ = std::max(frames.end_ns_, frames.reader_.last_time(id).value_or(0));
    }
  }
  frames.seek(0);
  return frames;
}

// Only chunks that hold such messages are opened.
void IndexedFrames::read_beside() {
  std::set<std::uint16_t> beside;
  for (const auto& [id, topic] : topics_) {
    if (lies_beside(topic)) {
      beside.insert(id);
    }
  }
  if (beside.empty()) {
    return;
  }
  reader_.choose(beside);
  FrameAssembler all;
  while (true) {
    const auto message = reader_.next();
    if (!message) {
      continue;
    }
    if (!*message) {
      break;
    }
    const Topic topic = topics_.at((*message)->channel_id);
    static_cast<void>(all.take(topic, **message));
    if (topic == Topic::kCalibration) {
      const std::optional<Packet> packet = decode_packet((*message)->data);
      if (packet) {
        if (const auto calibration = wire::read_calibration_packet(packet->payload)) {
          calibrations_.insert_or_assign((*message)->log_time, *calibration);
        }
      }
    }
  }
  events_ = all.sights().events;
  starts_ = all.sights().starts;
  std::ranges::sort(starts_);
  reader_.choose({});
}

std::vector<std::uint64_t> IndexedFrames::frame_times() {
  std::vector<std::uint64_t> all;
  for (const auto& [id, topic] : topics_) {
    if (topic == Topic::kFrameInfo) {
      const std::vector<std::uint64_t> times = reader_.times(id);
      all.insert(all.end(), times.begin(), times.end());
    }
  }
  std::ranges::sort(all);
  return all;
}

std::chrono::nanoseconds IndexedFrames::period(std::uint64_t log_time) const {
  const auto after = calibrations_.upper_bound(log_time);
  return std::chrono::nanoseconds(
      after == calibrations_.begin() ? 0 : std::prev(after)->second.period_ns);
}

void IndexedFrames::seek(std::uint64_t log_time) {
  const auto after = calibrations_.upper_bound(log_time);
  frames_ = FrameAssembler(
      after == calibrations_.begin() ? std::nullopt : std::optional(std::prev(after)->second));
  for (const auto& [id, topic] : topics_) {  // what was said before holds on
    if (topic == Topic::kHealth) {
      const std::uint64_t oldest = log_time - std::min(log_time, kHealthHoldsNs);
      if (const auto health = reader_.newest(id, oldest, log_time)) {
        static_cast<void>(frames_.take(topic, *health));
      }
    }
  }
  from_ = log_time;
  reader_.seek(log_time);
}

std::optional<RecordedFrame> IndexedFrames::next() {
  while (true) {
    const auto message = reader_.next();
    if (!message) {
      continue;  // of one chunk
    }
    if (!*message) {
      return frames_.end();
    }
    const auto topic = topics_.find((*message)->channel_id);
    if (topic == topics_.end() || (*message)->log_time < from_) {
      continue;
    }
    if (auto frame = frames_.take(topic->second, **message)) {
      return frame;
    }
  }
}

std::optional<RecordedFrame> IndexedFrames::last_before(std::uint64_t log_time) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 62;
  const std::uint64_t length = log_time - std::min(log_time, begin_ns());
  for (std::uint64_t back = kLookedThroughNs;; back *= 2) {
    const bool all = back >= std::min(length, kMost);
    seek(all ? 0 : log_time - back);
    std::optional<RecordedFrame> last;
    for (auto frame = next(); frame && frame->log_time < log_time; frame = next()) {
      last = std::move(frame);
    }
    if (last || all) {
      seek(last ? last->log_time + 1 : log_time);
      return last;
    }
  }
}

}  // namespace stof::recording
