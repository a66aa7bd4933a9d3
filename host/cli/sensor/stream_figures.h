#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/client/frame/frame.h"
#include "host/client/statistics.h"

namespace stof::host {

// Of what was measured once a frame, in one unit.
struct Spread {
  double mean = 0;
  double median = 0;
  double p99 = 0;
  double longest = 0;
};

// What frames came to: rates, jitter, latency. Without clock: times are given.
class StreamFigures {
 public:
  // arrived_s: of the last packet, by any clock that does not step, seconds. One earlier than that
  // of the frame before is of a file that somebody has put together: no time to it counts.
  void take(const client::Frame& frame, double arrived_s);

  // What follows is another stream: no time from one to the other counts.
  void begin_anew() noexcept;

  std::uint64_t frames() const noexcept { return frames_; }
  // From first to last arrival, of each stream.
  double seconds() const noexcept { return earlier_s_ + (newest_s_ - oldest_s_); }
  std::optional<double> rate_hz() const;  // of arrivals; none with fewer than two frames of one
  // All in milliseconds. Between two arrivals.
  std::optional<Spread> interval_ms() const;
  // From the middle of the exposure to the arrival of the last packet, where both clocks are one.
  std::optional<Spread> latency_ms() const;
  // From the middle of the exposure to the sending, as the sensor measures it.
  std::optional<Spread> sensor_latency_ms() const;
  std::optional<Spread> compute_ms() const;
  std::optional<double> coverage() const;  // mean share of pixels with a depth
  std::uint64_t stamps_back() const noexcept { return stamps_back_; }  // earlier than one before
  std::uint64_t arrivals_back() const noexcept { return arrivals_back_; }  // likewise

 private:
  void measure_anew() noexcept;

  std::uint64_t frames_ = 0;
  std::uint64_t streams_ = 1;
  bool begins_ = true;    // the next frame begins a stream
  double earlier_s_ = 0;  // of the streams before
  double oldest_s_ = 0;
  double newest_s_ = 0;
  double coverage_ = 0;  // sum
  std::uint64_t covered_frames_ = 0;
  std::uint64_t stamps_back_ = 0;
  std::uint64_t arrivals_back_ = 0;
  std::optional<wire::Origin> origin_;  // of the newest frame
  std::int64_t newest_stamp_ns_ = 0;
  std::vector<double> intervals_ms_;
  std::vector<double> latencies_ms_;
  std::vector<double> sensor_latencies_ms_;
  std::vector<double> compute_ms_;
};

// {"mean": ..., "median": ..., "p99": ..., "longest": ...}, or null.
nlohmann::ordered_json spread_json(const std::optional<Spread>& spread);
// "33.3 mean, 33.3 median, 34.9 p99, 40.1 longest"; "-" without.
std::string spread_text(const std::optional<Spread>& spread);

// Each cause of loss by its name of Statistics, in two groups: frames and packets.
nlohmann::ordered_json statistics_json(const client::Statistics& statistics);

}  // namespace stof::host
