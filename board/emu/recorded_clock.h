#pragma once

#include <chrono>
#include <optional>
#include <thread>

#include "hal/clock.h"

namespace stof::board {

// The clock of a recording: it begins at `start` and moves only when somebody waits. `paced`: from
// the first wait on, a wait lasts on this machine's clock until as much time has passed there as
// here, so whatever is due within a gap (health, the end of the program) is in time. Else each wait
// ends at once. One thread uses it.
class RecordedClock final : public hal::Clock {
 public:
  RecordedClock(hal::Time start, bool paced) noexcept : start_(start), now_(start), paced_(paced) {}

  hal::Time now() noexcept override { return now_; }
  void wait_until(hal::Time time) noexcept override {
    if (!began_) {
      began_ = std::chrono::steady_clock::now();
    }
    if (time <= now_) {
      return;
    }
    if (paced_) {
      std::this_thread::sleep_until(*began_ + (time - start_));
    }
    now_ = time;
  }

 private:
  hal::Time start_;
  hal::Time now_;
  bool paced_;
  std::optional<std::chrono::steady_clock::time_point> began_{};
};

}  // namespace stof::board
