#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <utility>

#include "host/client/statistics.h"
#include "host/recording/recording.h"

namespace stof::recording {

// A recording as its receiver got it: frame after frame, and beside them what the sensor said until
// then. For one thread.
class Playback {
 public:
  // Also of a cut one. A problem: no MCAP file.
  static std::expected<Playback, Problem> open(const std::filesystem::path& file);

  // The next frame, with the clock "recorded"; nothing at the end.
  std::optional<RecordedFrame> next();

  // The newest until the frame that next() gave last.
  const std::optional<wire::HealthReport>& health() const noexcept { return health_; }
  std::uint64_t health_at_ns() const noexcept { return health_at_ns_; }  // log time
  std::optional<wire::EventReport> take_event();
  // Frames and packets so far, sessions among them. Records that are damaged count as bad_crc.
  const client::Statistics& statistics() const noexcept { return statistics_; }

 private:
  explicit Playback(FrameReader&& reader) : reader_(std::move(reader)) {}
  void count(const RecordedFrame& frame);
  void look_beside(std::uint64_t until);

  FrameReader reader_;
  std::size_t health_seen_ = 0;  // of the reader's
  std::size_t events_seen_ = 0;
  std::uint64_t until_ = 0;  // log time of the frame that was given last
  std::optional<wire::HealthReport> health_;
  std::uint64_t health_at_ns_ = 0;
  std::optional<wire::Origin> origin_;
  std::uint32_t number_ = 0;
  client::Statistics statistics_{};
};

}  // namespace stof::recording
