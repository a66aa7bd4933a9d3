#include "firmware/keys/authenticator.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::keys {

Authenticator::Signer Authenticator::judge(const wire::SignedView& packet) noexcept {
  const wire::Key* key = ring_.keys().find(packet.fields.key_id);
  if (key == nullptr) {
    return {};
  }
  const bool newest = wire::signed_with(key->secret, packet);
  const bool former = !newest && key->former && wire::signed_with(*key->former, packet);
  if (!newest && !former) {
    return {};
  }
  std::uint64_t& highest = counter_of(key->id).highest;
  if (packet.fields.counter <= highest) {
    return {.verdict = Verdict::kReplayed, .key = key, .former = former, .highest = highest};
  }
  highest = packet.fields.counter;
  if (newest && key->former) {
    ring_.settle(packet.fields.key_id);
    key = ring_.keys().find(packet.fields.key_id);
  }
  return {.verdict = Verdict::kGood, .key = key, .former = former, .highest = highest};
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
