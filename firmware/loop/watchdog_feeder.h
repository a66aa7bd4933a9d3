#pragma once

#include "dsp/base/status.h"
#include "hal/clock.h"
#include "hal/watchdog.h"

namespace stof::firmware {

// Kicks the watchdog as long as the loop makes its rounds: a loop that stands still restarts the
// board.
class WatchdogFeeder {
 public:
  // watchdog: nullptr: nobody waits.
  WatchdogFeeder(hal::Watchdog* watchdog, hal::Clock& clock) noexcept
      : watchdog_(watchdog), clock_(clock) {}

  // After each round. Rounds may be as long as a third of the watchdog's timeout.
  void after_round() noexcept {
    if (watchdog_ == nullptr) {
      return;
    }
    const hal::Time now = clock_.now();
    if (now >= next_) {
      static_cast<void>(watchdog_->kick());  // a kick that fails is what the watchdog is there for
      next_ = now + watchdog_->timeout() / 8;
    }
  }

  // The loop ends as asked: nothing is to be restarted. kUnsupported, kDeviceError: it will be,
  // unless the program is started again in time.
  Status end() noexcept { return watchdog_ == nullptr ? Status::kOk : watchdog_->disarm(); }

 private:
  hal::Watchdog* watchdog_;
  hal::Clock& clock_;
  hal::Time next_{};
};

}  // namespace stof::firmware
