#pragma once

#include <atomic>
#include <cstdint>

#include "hal/button.h"
#include "hal/time.h"

namespace stof::hal::emu {

// Held down for as long as it is told, by whoever calls press(): any thread, or a signal handler.
class Button final : public hal::Button {
 public:
  // now: the clock that its time passes on.
  constexpr explicit Button(Time (*now)() noexcept) noexcept : now_(now) {}

  // From the next pressed() on, for that long.
  void press(Duration time) noexcept { time_ns_.store(time.count(), std::memory_order_relaxed); }
  // From now on it cannot be read.
  void break_down(Status why) noexcept { broken_ = why; }

  Result<bool> pressed() noexcept override;

 private:
  Time (*now_)() noexcept;
  std::atomic<std::int64_t> time_ns_ = 0;
  Time until_{};
  Status broken_ = Status::kOk;
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
};

}  // namespace stof::hal::emu
