#pragma once

#include <array>
#include <cstdint>

#include "firmware/control/token_bucket.h"
#include "firmware/keys/keyring.h"
#include "hal/time.h"

namespace stof::keys {

// How often keys may be written that need nobody at the sensor, each of which writes some tens of
// kilobytes of flash, and as many again when it is used or ended: each key renews itself so often,
// and so often the label's code makes one. Who renews takes nothing of the others. What ends a key
// is not limited: there are no more of these than were made. For the thread of the keyring.
class KeyWriteLimiter {
 public:
  static constexpr std::uint32_t kMostWrites = 10;                 // that a rest allows
  static constexpr hal::Duration kRefill = std::chrono::hours(1);  // until one more

  // The keyring outlives it.
  explicit KeyWriteLimiter(const Keyring& ring) noexcept : ring_(ring) {}

  // Whether one more may be written at `now`, which must not go back. key_id: that is renewed; 0:
  // one is made.
  bool may_write(std::uint32_t key_id, hal::Time now) noexcept;
  // The same, and uses it up.
  bool take(std::uint32_t key_id, hal::Time now) noexcept;

 private:
  struct Renewals {
    std::uint32_t key_id = 0;  // 0: nobody's
    firmware::TokenBucket bucket{kMostWrites, kRefill};
  };
  firmware::TokenBucket* bucket_of(std::uint32_t key_id) noexcept;

  const Keyring& ring_;
  firmware::TokenBucket made_{kMostWrites, kRefill};
  std::array<Renewals, kMostKeys> renewals_{};
};

}  // namespace stof::keys
