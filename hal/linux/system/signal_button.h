#pragma once

#include <string>

#include "hal/button.h"
#include "hal/time.h"

namespace stof::hal::linux {

// The button of a computer that has none: SIGUSR1 presses it for a moment, SIGUSR2 holds it for 6
// s, longer than anybody has to, as whoever looks may be busy. A signal that finds it pressed lets
// it go for a second before. Whoever may send these signals owns
// the process. From construction on; there is one at a time.
class SignalButton final : public hal::Button {
 public:
  SignalButton() noexcept;
  // now: another clock than CLOCK_MONOTONIC, that its time passes on.
  explicit SignalButton(Time (*now)() noexcept) noexcept;

  Result<bool> pressed() noexcept override;
  // A line: how to press and hold it.
  static std::string usage();

 private:
  Time (*now_)() noexcept;
  Time from_{};
  Time until_{};
};

}  // namespace stof::hal::linux
