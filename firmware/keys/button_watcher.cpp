#include "firmware/keys/button_watcher.h"

namespace stof::keys {

ButtonWatcher::Meaning ButtonWatcher::tick(hal::Time now) noexcept {
  const Result<bool> pressed = button_.pressed();
  if (!pressed) {  // what was begun is forgotten
    told_ = true;
    other_since_.reset();
    return Meaning::kNothing;
  }
  if (*pressed == down_) {
    other_since_.reset();
  } else if (!other_since_) {
    other_since_ = now;
  } else if (now - *other_since_ >= kBounce) {
    down_ = *pressed;
    const bool ended_untold = !down_ && !told_;
    if (down_) {
      down_since_ = *other_since_;
      told_ = false;
    }
    other_since_.reset();
    note_released(*pressed, now);
    return ended_untold ? Meaning::kPress : Meaning::kNothing;
  }
  note_released(*pressed, now);
  if (down_ && !told_ && now - down_since_ >= kHoldTime) {
    told_ = true;
    return Meaning::kHold;
  }
  return Meaning::kNothing;
}

// What bounces while it is held is no release.
void ButtonWatcher::note_released(bool pressed, hal::Time now) noexcept {
  if (!pressed && !down_) {
    released_at_ = now;
  }
}

}  // namespace stof::keys
