#pragma once

#include <chrono>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "host/recording/frame_assembler.h"
#include "host/recording/mcap/indexed_reader.h"

namespace stof::recording {

using mcap::Problem;

// Frames of a recording with a sound index, from any time on. Files without: FrameReader.
class IndexedFrames {
 public:
  // Reads the index, and beside it calibrations and events, which are few.
  static std::expected<IndexedFrames, Problem> open(const std::filesystem::path& file);

  // Log times of the first message and of the last frame, ns since 1970.
  std::uint64_t begin_ns() const { return reader_.index().statistics.start_time; }
  std::uint64_t end_ns() const noexcept { return end_ns_; }

  // The next frame is the first one of this time or later.
  void seek(std::uint64_t log_time);
  // Nothing at the end. What is damaged is left out.
  std::optional<RecordedFrame> next();
  // The last frame of before that time that can be read, wherever the next one was; nothing: there
  // is none. What comes next are frames behind it.
  std::optional<RecordedFrame> last_before(std::uint64_t log_time);
  // All of the file, with log times.
  const std::vector<std::pair<std::uint64_t, wire::EventReport>>& events() const noexcept {
    return events_;
  }
  // Log times of all frames, in order; only the index is read.
  std::vector<std::uint64_t> frame_times();
  // Log times from which on the sensor's starts are known, in order, the first one among them.
  const std::vector<std::uint64_t>& starts() const noexcept { return starts_; }
  // That the sensor told until that log time; 0: nobody knows.
  std::chrono::nanoseconds period(std::uint64_t log_time) const;
  // What the sensor had said of itself at that log time, of the last frame that was given or behind
  // what was sought; none: nobody knows.
  std::optional<wire::HealthReport> health(std::uint64_t log_time) const {
    return health_at(frames_.sights(), log_time);
  }

 private:
  IndexedFrames(std::unique_ptr<mcap::FileSource> source, mcap::IndexedReader&& reader);
  void read_beside();  // from the first message again

  std::unique_ptr<mcap::FileSource> source_;
  mcap::IndexedReader reader_;
  std::map<std::uint16_t, Topic> topics_;                          // of the channels that are ours
  std::map<std::uint64_t, wire::CalibrationPacket> calibrations_;  // by log time
  std::vector<std::pair<std::uint64_t, wire::EventReport>> events_;
  std::vector<std::uint64_t> starts_;
  FrameAssembler frames_;
  std::uint64_t from_ = 0;  // what is older is not shown
  std::uint64_t end_ns_ = 0;
};

}  // namespace stof::recording
