#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "host/client/frame/frame.h"
#include "host/client/session/link_watch.h"
#include "host/lib/include/stof/stof.h"
#include "host/recording/playback.h"

namespace stof::lib {

// A recording in the place of a receiver. For one thread.
class Played {
 public:
  Played(recording::Playback&& playback, std::uint32_t pace_percent)
      : playback_(std::move(playback)), pace_percent_(pace_percent) {}

  // The next frame, valid until the next call. STOF_TIMEOUT: it is not due yet; STOF_END.
  stof_status next(client::Duration timeout, client::Frame& frame);
  // The images of that frame move to `to`; once.
  bool keep(recording::RecordedFrame& to);

  // When the next frame is due; now, where frames come as they are asked for.
  client::Time due() const;
  // As of the newest frame, in the recording's time.
  client::LinkState link() const;
  recording::Playback& playback() { return playback_; }
  std::int64_t recorded_ns() const { return shown_ ? static_cast<std::int64_t>(at_ns_) : 0; }

 private:
  void plan(std::uint64_t log_time);

  recording::Playback playback_;
  std::uint32_t pace_percent_;                     // 0: as it is asked
  std::optional<recording::RecordedFrame> ahead_;  // read, and not yet due
  client::Time due_{};
  std::optional<recording::RecordedFrame> shown_;
  bool has_calibration_ = false;
  std::uint64_t at_ns_ = 0;  // log time of the frame that was given last; 0: none
};

}  // namespace stof::lib
