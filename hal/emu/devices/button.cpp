#include "hal/emu/devices/button.h"

namespace stof::hal::emu {

Result<bool> Button::pressed() noexcept {
  if (broken_ != Status::kOk) {
    return fail(broken_);
  }
  const Time now = now_();
  if (const std::int64_t time_ns = time_ns_.exchange(0, std::memory_order_relaxed); time_ns > 0) {
    until_ = now + Duration(time_ns);
  }
  return now < until_;
}

}  // namespace stof::hal::emu
