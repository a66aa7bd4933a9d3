#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/time.h"

namespace stof::firmware {

// Lets `most` pass after a rest, then one each time that `refill` has passed: full at the start.
class TokenBucket {
 public:
  constexpr TokenBucket() noexcept = default;
  constexpr TokenBucket(std::uint32_t most, hal::Duration refill) noexcept
      : step_(refill), depth_(most * refill) {}
  // As many as pass in a second.
  explicit constexpr TokenBucket(std::uint32_t per_second) noexcept
      : TokenBucket(per_second, hal::Duration(std::chrono::seconds(1)) / per_second) {}

  // Whether one more may pass at `now`, which must not go back.
  constexpr bool has(hal::Time now) const noexcept { return after_one_more(now) - now <= depth_; }
  // The same, and takes it.
  constexpr bool take(hal::Time now) noexcept {
    if (!has(now)) {
      return false;
    }
    full_at_ = after_one_more(now);
    return true;
  }

 private:
  // full_at_ is when the bucket would be full again; each token taken moves it by a step.
  constexpr hal::Time after_one_more(hal::Time now) const noexcept {
    return std::max(full_at_, now) + step_;
  }

  hal::Duration step_{};
  hal::Duration depth_{};
  hal::Time full_at_ = hal::Time::min();
};

}  // namespace stof::firmware
