#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/time.h"

namespace stof::firmware {

// At most `per_second` in any second after a rest, evenly refilled: full at the start.
class TokenBucket {
 public:
  explicit constexpr TokenBucket(std::uint32_t per_second) noexcept
      : step_(hal::Duration(std::chrono::seconds(1)) / per_second) {}

  // Whether one more may pass at `now`, which must not go back.
  constexpr bool take(hal::Time now) noexcept {
    // full_at_ is when the bucket would be full again; each token taken moves it by a step.
    const hal::Time after = std::max(full_at_, now) + step_;
    if (after - now > std::chrono::seconds(1)) {
      return false;
    }
    full_at_ = after;
    return true;
  }

 private:
  hal::Duration step_;
  hal::Time full_at_ = hal::Time::min();
};

}  // namespace stof::firmware
