#include "firmware/keys/pairing_attempts.h"

#include <algorithm>

namespace stof::keys {

using wire::PairMethod;

void PairingAttempt::end() noexcept {
  phase = Phase::kNone;
  has.emplace<std::monostate>();
}

PairingAttempts::Place& PairingAttempts::place_of(PairMethod method, std::uint32_t key_id,
                                                  bool proven) noexcept {
  if (method == PairMethod::kDigits) {
    return with_digits_;
  }
  if (!proven) {
    return unproven_;
  }
  switch (method) {
    case PairMethod::kKey:
      return of_key(key_id);
    case PairMethod::kCode:
      return with_code_;
    default:
      return with_cable_;
  }
}

// There are as many places as keys: one whose key has gone is free.
PairingAttempts::Place& PairingAttempts::of_key(std::uint32_t key_id) noexcept {
  auto place = std::ranges::find(renewals_, key_id, &Place::key_id);
  if (place == renewals_.end()) {
    place = std::ranges::find_if(
        renewals_, [this](const Place& one) { return ring_.keys().find(one.key_id) == nullptr; });
    if (place == renewals_.end()) {
      return unproven_;
    }
    place->attempt.end();
    place->key_id = key_id;
    place->begins_full_at = firmware::TokenRate::kFull;
  }
  return *place;
}

bool PairingAttempts::take_begin(Place& place, hal::Time now) noexcept {
  constexpr firmware::TokenRate kBegins(kMostBegins, kBeginRefill);
  return kBegins.take(place.begins_full_at, now);
}

template <typename Action>
void PairingAttempts::each_known(Action action) noexcept {
  action(with_cable_.attempt);
  action(with_code_.attempt);
  action(unproven_.attempt);
  for (Place& renewal : renewals_) {
    action(renewal.attempt);
  }
}

PairingAttempt* PairingAttempts::find(PairMethod method, std::uint64_t number) noexcept {
  PairingAttempt* found = nullptr;
  const auto look = [&](PairingAttempt& attempt) {
    if (attempt.phase != PairingAttempt::Phase::kNone && attempt.number == number &&
        attempt.said.method == method) {
      found = &attempt;
    }
  };
  look(with_digits_.attempt);
  each_known(look);
  return found;
}

void PairingAttempts::expire(hal::Time now) noexcept {
  each_known([now](PairingAttempt& attempt) {
    if (attempt.phase != PairingAttempt::Phase::kNone && now >= attempt.until) {
      attempt.end();
    }
  });
}

}  // namespace stof::keys
