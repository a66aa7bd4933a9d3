#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace stof::bridge {

// Lines of a library, of which somebody on the network decides how many there are: the first ten of
// a minute, printable. The first line behind those that were left out says how many they were. Any
// thread may call.
class LineLimit {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr int kLines = 10;
  static constexpr Clock::duration kWindow = std::chrono::minutes(1);

  // What to write for a line that came then, without the end of a line.
  std::optional<std::string> pass(std::string_view line, Clock::time_point now);

 private:
  std::mutex mutex_;
  std::optional<Clock::time_point> begin_;  // of the minute
  long passed_ = 0;                         // in it
  long left_out_ = 0;                       // since a line was written
};

}  // namespace stof::bridge
