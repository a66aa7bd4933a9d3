#pragma once

#include <algorithm>
#include <chrono>

namespace stof::viewer {

// So many at once, and then one each so often.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;
  RateLimit(int most, Clock::duration each) : most_(most), each_(each) {}

  // Whether one more may be; `now` does not go back.
  bool take(Clock::time_point now) {
    // When all that were taken are forgotten.
    const Clock::time_point free = std::max(free_, now);
    if (free + each_ - now > most_ * each_) {
      return false;
    }
    free_ = free + each_;
    return true;
  }

 private:
  int most_;
  Clock::duration each_;
  Clock::time_point free_{};
};

}  // namespace stof::viewer
