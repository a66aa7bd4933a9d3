#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/client/receiver.h"

// What scripts/link_bench runs beside stofd. Each command prints one JSON object a line; times are
// of CLOCK_MONOTONIC, in ns where the name says so, else in ms.
namespace stof::bench {

using Words = std::vector<std::string>;

// receive SENSOR SECONDS [KEYS]: with keys, streams that are signed for it. A line for the first
// frame of each session, one for each health, and a summary at the end, which SIGTERM brings as
// well; 0 seconds: only that.
int receive(const Words& words);
// cycles SENSOR COUNT CLIENTS: subscribe, first frame, unsubscribe; a summary.
int cycles(const Words& words);
// flood HOST:PORT COUNT RATE SEED: malformed requests, at most RATE a second; a summary.
int flood(const Words& words);
// attack HOST:PORT COUNT RATE SEED KEYS: changes without a key, with captured, repeated, changed
// and guessed requests, RATE a second; a summary. KEYS: of whoever they are captured from.
int attack(const Words& words);
// compare SENSOR IMPAIRED FRAMES: rows that arrive by way of IMPAIRED beside those that come
// straight from SENSOR; a summary.
int compare(const Words& words);

// Whether frames advance: in number and freshness within a session, and no session comes back.
class Order {
 public:
  // True: the frame is newer than all before. A frame of a new session is.
  bool advances(const client::Frame& frame);
  bool new_session() const noexcept { return new_session_; }

 private:
  std::vector<std::uint32_t> sessions_;
  wire::FrameStamp newest_{};
  bool new_session_ = false;
};

constexpr bool newer(std::uint32_t number, std::uint32_t than) noexcept {
  return static_cast<std::int32_t>(number - than) > 0;
}

// "p50":1.000,"p99":2.000,"max":3.000 with `name` before each; zeros for no values.
std::string quantiles(std::string_view name, std::vector<double> values);
std::string json(const client::Statistics& statistics);
std::string json(const wire::ControlCounters& counters);
double milliseconds(client::Duration duration);
std::int64_t nanoseconds(client::Time time);

// Ends the program with one line where the sensor cannot be subscribed at.
client::Receiver subscribe(const std::string& sensor, const std::string& keys = {});

}  // namespace stof::bench
