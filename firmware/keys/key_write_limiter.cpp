#include "firmware/keys/key_write_limiter.h"

#include <algorithm>

namespace stof::keys {

// There are as many places as keys: one whose key has gone is free. nullptr: that key has gone
// itself.
firmware::TokenBucket* KeyWriteLimiter::bucket_of(std::uint32_t key_id) noexcept {
  if (key_id == 0) {
    return &made_;
  }
  auto place = std::ranges::find(renewals_, key_id, &Renewals::key_id);
  if (place == renewals_.end()) {
    place = std::ranges::find_if(renewals_, [this](const Renewals& renewals) {
      return ring_.keys().find(renewals.key_id) == nullptr;
    });
    if (place == renewals_.end()) {
      return nullptr;
    }
    *place = {.key_id = key_id};
  }
  return &place->bucket;
}

bool KeyWriteLimiter::may_write(std::uint32_t key_id, hal::Time now) noexcept {
  const firmware::TokenBucket* const bucket = bucket_of(key_id);
  return bucket != nullptr && bucket->has(now);
}

bool KeyWriteLimiter::take(std::uint32_t key_id, hal::Time now) noexcept {
  firmware::TokenBucket* const bucket = bucket_of(key_id);
  return bucket != nullptr && bucket->take(now);
}

}  // namespace stof::keys
