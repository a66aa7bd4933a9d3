#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/time.h"

namespace stof::firmware {

// How fast a bucket fills, and how many tokens it holds: many buckets may share one, each with the
// time when it would be full again.
class TokenRate {
 public:
  constexpr TokenRate() noexcept = default;
  constexpr TokenRate(std::uint32_t most, hal::Duration refill) noexcept
      : step_(refill), depth_(most * refill) {}
  // As many as pass in a second.
  explicit constexpr TokenRate(std::uint32_t per_second) noexcept
      : TokenRate(per_second, hal::Duration(std::chrono::seconds(1)) / per_second) {}

  // Full at the start.
  static constexpr hal::Time kFull = hal::Time::min();
  // Whether one more may pass at `now`, which must not go back.
  constexpr bool has(hal::Time full_at, hal::Time now) const noexcept {
    return after_one_more(full_at, now) - now <= depth_;
  }
  // The same, and takes it.
  constexpr bool take(hal::Time& full_at, hal::Time now) const noexcept {
    if (!has(full_at, now)) {
      return false;
    }
    full_at = after_one_more(full_at, now);
    return true;
  }

 private:
  // Each token taken moves the time by a step.
  constexpr hal::Time after_one_more(hal::Time full_at, hal::Time now) const noexcept {
    return std::max(full_at, now) + step_;
  }

  hal::Duration step_{};
  hal::Duration depth_{};
};

// Lets `most` pass after a rest, then one each time that `refill` has passed.
class TokenBucket {
 public:
  constexpr TokenBucket() noexcept = default;
  constexpr TokenBucket(std::uint32_t most, hal::Duration refill) noexcept : rate_(most, refill) {}
  explicit constexpr TokenBucket(std::uint32_t per_second) noexcept : rate_(per_second) {}

  // Whether one more may pass at `now`, which must not go back.
  constexpr bool has(hal::Time now) const noexcept { return rate_.has(full_at_, now); }
  // The same, and takes it.
  constexpr bool take(hal::Time now) noexcept { return rate_.take(full_at_, now); }

 private:
  TokenRate rate_;
  hal::Time full_at_ = TokenRate::kFull;
};

}  // namespace stof::firmware
