#pragma once

#include <array>
#include <cstdint>
#include <variant>

#include "firmware/control/token_bucket.h"
#include "firmware/keys/keyring.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/pair_secrets.h"
#include "hal/time.h"

namespace stof::keys {

// By which one secret is told from another, without a copy of it. Says nothing about it.
std::uint64_t mark_of(const wire::Secret& secret) noexcept;

// One client on its way to a key.
struct PairingAttempt {
  enum class Phase : std::uint8_t { kNone, kBegun, kRevealed, kProven, kDone };

  Phase phase = Phase::kNone;
  std::uint64_t number = 0;
  hal::Time until{};
  std::array<std::uint8_t, 16> from{};  // of who began it, from where all its steps come
  std::uint64_t stands_on = 0;          // of method key: mark_of() the secret that both know
  wire::Digest commitment{};
  wire::PairTranscript said{};
  // Before both have revealed, and after.
  std::variant<std::monostate, wire::Exchange, wire::PairSecrets> has{};

  const wire::Exchange* exchange() const noexcept { return std::get_if<wire::Exchange>(&has); }
  const wire::PairSecrets* secrets() const noexcept { return std::get_if<wire::PairSecrets>(&has); }
  void end() noexcept;
};

// The attempts that may go on at the same time. With digits there is one. Of the other methods each
// key has one of its own, and so have the code and the cable, for who has shown at begin that he
// knows it (or holds it); all others share one. So nobody ends or holds up an attempt of whoever
// knows more than he does. For one thread; no heap.
class PairingAttempts {
 public:
  // So many may begin at once in each place, then one each time: it costs two multiplications of a
  // curve.
  static constexpr std::uint32_t kMostBegins = 20;
  static constexpr hal::Duration kBeginRefill = std::chrono::milliseconds(100);

  // Where an attempt begins.
  struct Place {
    std::uint32_t key_id = 0;  // of a key's own; 0: nobody's
    PairingAttempt attempt{};
    hal::Time begins_full_at = firmware::TokenRate::kFull;
  };

  // The keyring outlives it.
  explicit PairingAttempts(const Keyring& ring) noexcept : ring_(ring) {}

  PairingAttempt& with_digits() noexcept { return with_digits_.attempt; }
  const PairingAttempt& with_digits() const noexcept { return with_digits_.attempt; }
  // proven: that who begins knows the code, the key, or holds the cable. A key is in the ring.
  Place& place_of(wire::PairMethod method, std::uint32_t key_id, bool proven) noexcept;
  // Whether one may begin there now; if so, it counts.
  static bool take_begin(Place& place, hal::Time now) noexcept;
  // That goes on, with that number, of a client there; nullptr: there is none. Who overhears the
  // number ends nothing from his own address.
  PairingAttempt* find(wire::PairMethod method, std::uint64_t number,
                       const std::array<std::uint8_t, 16>& from) noexcept;
  // Ends those whose time is over; with digits there is none.
  void expire(hal::Time now) noexcept;

 private:
  Place& of_key(std::uint32_t key_id) noexcept;
  template <typename Action>
  void each_known(Action action) noexcept;

  const Keyring& ring_;
  Place with_digits_;
  Place with_cable_;
  Place with_code_;
  Place unproven_;
  std::array<Place, kMostKeys> renewals_{};
};

}  // namespace stof::keys
