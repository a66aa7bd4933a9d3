#pragma once

#include <cstdint>
#include <optional>

#include "hal/button.h"
#include "hal/time.h"

namespace stof::keys {

// What somebody means who presses a button. Contacts bounce: a state counts when it has lasted.
class ButtonWatcher {
 public:
  enum class Meaning : std::uint8_t { kNothing, kPress, kHold };
  static constexpr hal::Duration kHoldTime = std::chrono::seconds(3);
  static constexpr hal::Duration kBounce = std::chrono::milliseconds(30);

  // The button outlives it. One that is held down at the start says nothing.
  explicit ButtonWatcher(hal::Button& button) noexcept : button_(button) {}

  // Each press once: kHold as soon as it has lasted kHoldTime, kPress when it ends before. Call it
  // at least ten times a second.
  Meaning tick(hal::Time now) noexcept;
  // When it was last seen released: what it means began after that. None: never yet.
  std::optional<hal::Time> released_at() const noexcept { return released_at_; }

 private:
  void note_released(bool pressed, hal::Time now) noexcept;

  hal::Button& button_;
  bool down_ = true;  // as it counts
  bool told_ = true;  // what this press means
  std::optional<hal::Time> other_since_;
  hal::Time down_since_{};
  std::optional<hal::Time> released_at_;
};

}  // namespace stof::keys
