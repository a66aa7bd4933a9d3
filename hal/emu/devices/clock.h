#pragma once

#include "hal/clock.h"

namespace stof::hal::emu {

// Time that moves only when somebody waits: wait_until(t) makes it t, at once. Computing takes no
// time, so a run depends on nothing but its inputs. One thread uses it.
class Clock final : public hal::Clock {
 public:
  // Far from zero, as on a machine that has been up for a while: a zero stamp is never recent.
  static constexpr Time kStart{std::chrono::seconds(1000)};

  constexpr explicit Clock(Time start = kStart) noexcept : now_(start) {}

  Time now() noexcept override { return now_; }
  void wait_until(Time time) noexcept override { now_ = time > now_ ? time : now_; }

 private:
  Time now_;
};

}  // namespace stof::hal::emu
