#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <expected>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "host/recording/frame_messages.h"
#include "host/recording/mcap/writer.h"

namespace stof::recording {

using mcap::Problem;

struct RecorderOptions {
  std::string library{};  // of the file's header: the program and its version
  // Flushes follow each other so; with the time that a disk takes for one a second passes.
  std::chrono::milliseconds sync_period{900};
  std::size_t queue_bytes = std::size_t{128} << 20;  // that may wait for the disk
};

struct OwnedAttachment {
  std::string name{};
  std::string media_type{};
  std::uint64_t log_time = 0;
  Buffer data{};
};

// Writes a recording from a thread of its own, so that a slow disk keeps no receiver waiting. What
// was handed over is on the disk after sync_period and the time that the disk takes.
class Recorder {
 public:
  // Writes the begin of the file. The sink is used by the recorder's thread alone from now on, and
  // outlives it.
  static std::expected<std::unique_ptr<Recorder>, Problem> start(mcap::ByteSink& sink,
                                                                 const RecorderOptions& options);
  ~Recorder();  // as finish(), without its answer
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // All of them, or none where the queue is full (false). Never waits.
  bool put(TopicMessages&& messages);
  void put(mcap::Metadata&& metadata);
  void put(OwnedAttachment&& attachment);

  // Whether the disk refused something: from then on nothing is taken.
  bool failed() const;

  struct Ended {
    std::optional<Problem> problem{};  // the file ends before what was handed over last
    bool indexed = true;
    mcap::Statistics statistics{};  // of the file, as the two that follow
    std::uint64_t frames = 0;
    std::uint64_t exposures = 0;  // with raw pictures
    std::uint64_t bytes = 0;
  };
  // Writes all that waits, and ends the file. Once.
  Ended finish();

 private:
  // What one call of put() handed over.
  struct Batch {
    TopicMessages messages{};
    std::optional<mcap::Metadata> metadata{};
    std::optional<OwnedAttachment> attachment{};
    std::size_t bytes = 0;
  };

  Recorder(mcap::Writer&& writer, RecorderOptions options);
  void run();
  std::expected<void, Problem> write(const Batch& batch);
  bool enqueue(Batch&& batch, bool always);
  std::uint64_t messages_of(Topic topic) const;

  mcap::Writer writer_;  // of the thread
  RecorderOptions options_;
  std::map<Topic, std::uint16_t> channels_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Batch> queue_;
  std::size_t queued_bytes_ = 0;
  bool stop_ = false;
  Ended ended_;
  std::thread thread_;
};

}  // namespace stof::recording
