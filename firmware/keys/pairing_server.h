#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/events/events.h"
#include "firmware/keys/button_watcher.h"
#include "firmware/keys/key_write_limiter.h"
#include "firmware/keys/keyring.h"
#include "firmware/keys/pairing_attempts.h"
#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/pair_secrets.h"
#include "firmware/wire/messages/pair_answer.h"
#include "firmware/wire/messages/pair_request.h"
#include "hal/datagram_port.h"
#include "hal/time.h"

namespace stof::keys {

using LabelCode = std::array<std::byte, 16>;

// Where a request came from.
enum class PairingWay : std::uint8_t { kNetwork, kCable };

// The sensor's end of pairing: any requests in, at most one key out of each attempt. With digits it
// takes somebody at the sensor, twice: one press, or a request over the cable, opens two minutes
// for one client, and once the digits of both ends are told, somebody accepts them there, with the
// button or over the cable. Two clients in these minutes end both, a press ends what is under way.
// A hold counts that begins after the digits were told. Keys that both know, or the
// label's code, need nobody, and are limited for that (KeyWriteLimiter); whoever shows at begin
// that he knows them is kept from it by nobody who does not (PairingAttempts). For one thread; no
// clock, no heap.
class PairingServer {
 public:
  static constexpr hal::Duration kWindow = std::chrono::minutes(2);
  static constexpr hal::Duration kKnownTime =
      std::chrono::seconds(10);  // of an attempt without digits

  // code: of the label; none: there is none. The keyring outlives it.
  PairingServer(const wire::Origin& sensor, Keyring& ring,
                const std::optional<LabelCode>& code) noexcept
      : sensor_(sensor), ring_(ring), code_(code), attempts_(ring), writes_(ring) {}

  // A new window, and nothing of the last one.
  void open(hal::Time now) noexcept;
  // The button was pressed: opens, or where a client is at it ends that and closes. Where digits
  // were told, and their attempt ended without a key in the last two minutes, it opens nothing the
  // first time: it may be the hold, too short, of somebody who does not know yet.
  void press(hal::Time now) noexcept;
  // It is held, and was last released then: accepts the digits, if they had been told.
  void hold(std::optional<hal::Time> released_at) noexcept;
  // What whoever has the button in hand means by it. Before tick() of that time.
  void take(ButtonWatcher& button, hal::Time now) noexcept;
  // Ends what is too old, and tells how it stands.
  void tick(hal::Time now) noexcept;

  // Gets each key that comes of it, and, by tick(), how pairing at the sensor stands: the digits
  // with the role and the address that they are for. Outlives it.
  void set_changes(firmware::ChangeRing* changes) noexcept { changes_ = changes; }

  // request_id and cookie are the caller's. from: none over the cable. May block for as long as
  // saving a file takes.
  wire::PairAnswer serve(const wire::PairRequest& request, PairingWay way, hal::Time now,
                         const hal::Peer& from = {}) noexcept;

  bool is_open() const noexcept {
    return open_until_.has_value() && attempts_.with_digits().phase != Phase::kDone;
  }
  // That the sensor tells, while somebody may accept them, with asked_role() and asked_from().
  std::optional<std::uint32_t> digits() const noexcept;
  // What whoever accepts the digits agrees to: the role that the key gets, and who asked for it (as
  // in hal::Peer; all 0: over the cable). The role is among what the digits are made of.
  wire::Role asked_role() const noexcept { return attempts_.with_digits().said.role; }
  const std::array<std::uint8_t, 16>& asked_from() const noexcept {
    return attempts_.with_digits().from;
  }
  // A key came of the digits, in these two minutes.
  bool is_done() const noexcept { return attempts_.with_digits().phase == Phase::kDone; }

 private:
  using Phase = PairingAttempt::Phase;
  using Attempt = PairingAttempt;

  void expire(hal::Time now) noexcept;
  void accept() noexcept;
  // The cable's own steps: none of them is served over the network.
  wire::PairAnswer serve_cable(const wire::PairRequest& request, hal::Time now) noexcept;
  // How the two minutes stand that the cable opened.
  wire::PairAnswer window() const noexcept;
  // Whether a client may begin so, now.
  bool may_begin(const wire::PairRequest& request, PairingWay way) const noexcept;
  // What whoever begins shows of himself.
  struct Claim {
    bool proven = false;          // that he knows what both know, or holds the cable
    std::uint64_t stands_on = 0;  // as in PairingAttempt
  };
  Claim claim_of(const wire::PairRequest& begin, PairingWay way) const noexcept;
  // What both knew before; none: the sensor does not any more.
  std::optional<std::span<const std::byte>> known(const Attempt& attempt) const noexcept;
  wire::PairAnswer begin(const wire::PairRequest& request, PairingWay way, hal::Time now,
                         const hal::Peer& from) noexcept;
  wire::PairAnswer reveal(const wire::PairRequest& request, Attempt& attempt) noexcept;
  wire::PairAnswer confirm(const wire::PairRequest& request, Attempt& attempt,
                           hal::Time now) noexcept;
  wire::PairAnswer finish(Attempt& attempt) noexcept;
  Status keep(const Attempt& attempt) noexcept;
  void tell(const Attempt& attempt) noexcept;
  firmware::Event state() const noexcept;
  void tell_state(hal::Time now) noexcept;
  void end(Attempt& attempt) noexcept;
  wire::PairAnswer fail(Attempt& attempt, wire::PairResult why) noexcept;
  static wire::PairAnswer answer(const Attempt& attempt, wire::PairResult result) noexcept;

  wire::Origin sensor_;
  Keyring& ring_;
  std::optional<LabelCode> code_;
  std::optional<hal::Time> open_until_;
  std::optional<wire::PairNonce> opened_by_;  // of the cable's request; none: the button
  bool pressed_away_ = false;                 // the last window
  std::uint64_t not_kept_ = 0;                // number of the last attempt whose key was not
  PairingAttempts attempts_;
  std::optional<hal::Time> cut_until_;  // a press opens nothing; none: it does
  std::optional<hal::Time> told_at_;    // the digits
  bool accepted_ = false;               // likewise
  KeyWriteLimiter writes_;
  firmware::ChangeRing* changes_ = nullptr;
  firmware::Event told_{.kind = firmware::EventKind::kPairing};  // of how pairing stands, the last
};

}  // namespace stof::keys
