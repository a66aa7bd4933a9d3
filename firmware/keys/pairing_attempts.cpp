#include "firmware/keys/pairing_attempts.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "firmware/wire/bytes.h"

namespace stof::keys {

using wire::PairMethod;

std::uint64_t mark_of(const wire::Secret& secret) noexcept {
  constexpr std::string_view kWhat = "stof secret's mark";
  const wire::Digest digest = wire::digest_of(secret, {std::as_bytes(std::span(kWhat))});
  return wire::get_u64(std::span(digest).first<8>());
}

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

PairingAttempt* PairingAttempts::find(PairMethod method, std::uint64_t number,
                                      const std::array<std::uint8_t, 16>& from) noexcept {
  PairingAttempt* found = nullptr;
  const auto look = [&](PairingAttempt& attempt) {
    if (attempt.phase != PairingAttempt::Phase::kNone && attempt.number == number &&
        attempt.said.method == method && attempt.from == from) {
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
