#include "firmware/keys/authenticator.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::keys {

Authenticator::Signer Authenticator::judge(const wire::SignedView& packet) noexcept {
  const wire::Key* const key = ring_.keys().find(packet.fields.key_id);
  if (key == nullptr || !wire::signed_with(key->secret, packet)) {
    return {};
  }
  std::uint64_t& highest = counter_of(key->id).highest;
  if (packet.fields.counter <= highest) {
    return {.verdict = Verdict::kReplayed, .key = key, .highest = highest};
  }
  highest = packet.fields.counter;
  return {.verdict = Verdict::kGood, .key = key, .highest = highest};
}

// There are as many places as keys: one whose key has gone is free.
Authenticator::Counter& Authenticator::counter_of(std::uint32_t key_id) noexcept {
  if (const auto own = std::ranges::find(counters_, key_id, &Counter::key_id);
      own != counters_.end()) {
    return *own;
  }
  const auto free = std::ranges::find_if(counters_, [this](const Counter& counter) {
    return ring_.keys().find(counter.key_id) == nullptr;
  });
  STOF_CHECK(free != counters_.end());
  *free = {.key_id = key_id, .highest = 0};
  return *free;
}

}  // namespace stof::keys
