#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/wire/frame_info.h"
#include "host/client/frame/frame.h"
#include "host/client/statistics.h"
#include "host/evaluate/fusion/depth_score.h"

namespace stof::host {

// Milliseconds from the middle of the exposure to the last packet of the frame, both on this
// machine's CLOCK_MONOTONIC. None where the sender's clock is an emulated one, or differs from ours
// by more than a minute.
std::optional<double> latency_ms(const client::Frame& frame);

// Share of pixels that have a depth.
double coverage(const client::Frame& frame);

// ", drift: pitch 0.104 +- 0.008 deg: calibrate the rig anew" for the drifts that are significant;
// empty without any.
std::string drift_text(const wire::FrameInfo& info);

// Collects the figures of each second's line.
class StatusLine {
 public:
  void count(const client::Frame& frame);
  // A second has passed since the first frame, or since the last line.
  bool due(client::Time now) const { return began_ && now - since_ >= std::chrono::seconds(1); }
  // Something was counted since the last line.
  bool pending() const { return frames_ > 0; }

  // The second's line; begins the next second. Times count from the first frame's arrival; the rate
  // is that of the frames' arrivals. score: of the newest whole frame, where there is truth.
  std::string line(client::Time now, const client::Statistics& statistics,
                   const std::optional<DepthScore>& score);

 private:
  double rate() const;

  std::optional<client::Time> began_;  // arrival of the first frame
  client::Time since_;                 // the last line
  client::Time newest_;                // arrival of the newest frame
  client::Time counted_from_;          // arrival of the frame before the ones in intervals_
  std::uint64_t intervals_ = 0;        // between arrivals since then
  std::uint64_t frames_ = 0;
  double coverage_ = 0;  // sum over frames_
  // Of frames_, by what they stand on; empty where the rig has one sensor.
  std::array<std::uint64_t, wire::kBothSensors + 1> by_sensors_{};
  std::vector<double> latencies_ms_;
  std::string drift_;  // of the newest frame; empty: nothing to say
};

// The last line: frames received and verified, and what was lost, by cause.
std::string summary_line(const client::Statistics& statistics);

}  // namespace stof::host
