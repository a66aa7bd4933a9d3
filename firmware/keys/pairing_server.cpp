#include "firmware/keys/pairing_server.h"

#include <algorithm>
#include <string_view>

#include "firmware/wire/bytes.h"

namespace stof::keys {

using wire::PairAnswer;
using wire::PairMethod;
using wire::PairRequest;
using wire::PairResult;

namespace {

std::uint64_t random_number() noexcept {
  std::array<std::byte, 8> bytes{};
  wire::fill_random(bytes);
  return wire::get_u64(bytes);
}

// Random, of no key that is here.
std::uint32_t free_key_id(const wire::KeyTable& keys) noexcept {
  std::uint32_t id = 0;
  while (id == 0 || keys.find(id) != nullptr) {
    id = static_cast<std::uint32_t>(random_number());
  }
  return id;
}

// Whether nobody has to be at the sensor for it.
bool needs_nobody(PairMethod method) noexcept {
  return method == PairMethod::kKey || method == PairMethod::kCode;
}

// A role that there is, and a name as keys have it, filled up with 0.
bool well_formed(const PairRequest& request) noexcept {
  const auto end = std::ranges::find(request.name, '\0');
  const std::string_view name(request.name.data(),
                              static_cast<std::size_t>(end - request.name.begin()));
  return request.role >= wire::Role::kView && request.role <= wire::Role::kAdmin &&
         std::ranges::equal(wire::key_name(name), request.name);
}

}  // namespace

void PairingServer::open(hal::Time now) noexcept {
  end(attempts_.with_digits());
  open_until_ = now + kWindow;
  opened_by_.reset();
  pressed_away_ = false;
  cut_until_.reset();
}

void PairingServer::press(hal::Time now) noexcept {
  const Phase phase = attempts_.with_digits().phase;
  if ((phase == Phase::kNone || phase == Phase::kDone) && !cut_until_) {
    open(now);
    told_ = {.kind =
                 firmware::EventKind::kPairing};  // two minutes more of an open one are told, too
    return;
  }
  end(attempts_.with_digits());
  open_until_.reset();
  pressed_away_ = true;
  cut_until_.reset();
}

void PairingServer::hold(std::optional<hal::Time> released_at) noexcept {
  if (accepted_) {
    return;
  }
  if (digits() && told_at_ && released_at && *released_at >= *told_at_) {
    accept();
  } else if (changes_ != nullptr) {
    firmware::Event vain = state();
    vain.former = firmware::kPairingHeldInVain;
    static_cast<void>(changes_->push(vain));
  }
}

void PairingServer::take(ButtonWatcher& button, hal::Time now) noexcept {
  switch (button.tick(now)) {
    case ButtonWatcher::Meaning::kPress:
      press(now);
      break;
    case ButtonWatcher::Meaning::kHold:
      hold(button.released_at());
      break;
    case ButtonWatcher::Meaning::kNothing:
      break;
  }
}

void PairingServer::accept() noexcept {
  if (attempts_.with_digits().phase == Phase::kRevealed ||
      attempts_.with_digits().phase == Phase::kProven) {
    accepted_ = true;
    if (attempts_.with_digits().phase == Phase::kProven) {
      static_cast<void>(finish(attempts_.with_digits()));
    }
  }
}

void PairingServer::expire(hal::Time now) noexcept {
  if (open_until_ && now >= *open_until_) {
    open_until_.reset();
    end(attempts_.with_digits());
  }
  if (cut_until_) {
    cut_until_ = std::min(*cut_until_, now + kWindow);
    if (now >= *cut_until_) {
      cut_until_.reset();
    }
  }
  attempts_.expire(now);
}

// Told here alone: so the button was looked at before, at the same time.
void PairingServer::tick(hal::Time now) noexcept {
  expire(now);
  tell_state(now);
}

firmware::Event PairingServer::state() const noexcept {
  firmware::Event event{.kind = firmware::EventKind::kPairing};
  if (const std::optional<std::uint32_t> told = digits()) {
    event.value = firmware::kPairingTold + *told;
    event.role = asked_role();
    event.address = asked_from();
  } else if (is_open()) {
    event.value = firmware::kPairingOpen;
  } else {
    event.value = is_done() ? firmware::kPairingDone : firmware::kPairingClosed;
    event.former = pressed_away_ ? firmware::kPairingPressed : 0;
  }
  return event;
}

// Each state once. One that finds no room is told by the next tick.
void PairingServer::tell_state(hal::Time now) noexcept {
  const firmware::Event event = state();
  const bool untold_digits = digits() && !told_at_;
  if (event.value == told_.value && event.former == told_.former && event.role == told_.role &&
      event.address == told_.address && !untold_digits) {
    return;
  }
  const bool over =
      told_.value == firmware::kPairingDone && event.value == firmware::kPairingClosed;
  if (over || changes_ == nullptr || changes_->push(event)) {
    told_ = event;
    if (untold_digits) {
      told_at_ = now;
    }
  }
}

std::optional<std::uint32_t> PairingServer::digits() const noexcept {
  const bool told = attempts_.with_digits().phase == Phase::kRevealed ||
                    attempts_.with_digits().phase == Phase::kProven;
  return told ? std::optional(attempts_.with_digits().secrets()->digits()) : std::nullopt;
}

PairAnswer PairingServer::serve(const PairRequest& request, PairingWay way, hal::Time now,
                                const hal::Peer& from) noexcept {
  expire(now);
  if (request.step > wire::PairStep::kAccept) {
    return {.result = PairResult::kWrong};  // of a newer client
  }
  if (request.step == wire::PairStep::kBegin) {
    return begin(request, way, now, from);
  }
  if (request.step == wire::PairStep::kOpen || request.step == wire::PairStep::kAccept) {
    return way == PairingWay::kCable ? serve_cable(request, now)
                                     : PairAnswer{.result = PairResult::kClosed};
  }
  Attempt* const attempt = attempts_.find(request.method, request.attempt, from.address);
  if (attempt == nullptr) {
    const bool full = request.attempt != 0 && request.attempt == not_kept_;
    return {.result = full ? PairResult::kFull : PairResult::kWrong};
  }
  return request.step == wire::PairStep::kReveal ? reveal(request, *attempt)
                                                 : confirm(request, *attempt, now);
}

PairAnswer PairingServer::serve_cable(const PairRequest& request, hal::Time now) noexcept {
  if (request.step == wire::PairStep::kOpen) {
    const auto nonce = wire::bytes_in<wire::PairNonce>(request.nonce);
    if (opened_by_ != nonce) {  // else its answer was lost, or somebody waits
      open(now);
      opened_by_ = nonce;
    }
    return window();
  }
  const std::span<const std::byte> value = std::as_bytes(std::span(request.value));
  const std::uint32_t digits = wire::get_u32(value.first<4>());
  if (attempts_.with_digits().secrets() == nullptr) {
    if (digits >= wire::kDigitsEnd) {  // whoever opened gives up
      open_until_.reset();
      end(attempts_.with_digits());
    }
    return {.result = PairResult::kWrong};
  }
  if (digits != attempts_.with_digits().secrets()->digits()) {
    return attempts_.with_digits().phase == Phase::kDone
               ? PairAnswer{.result = PairResult::kWrong}
               : fail(attempts_.with_digits(), PairResult::kWrong);
  }
  accept();
  return window();
}

PairAnswer PairingServer::window() const noexcept {
  if (attempts_.with_digits().phase == Phase::kDone) {
    return {.result = PairResult::kOk, .key_id = attempts_.with_digits().said.key_id};
  }
  const std::optional<std::uint32_t> told = digits();
  if (!told) {
    return {.result = open_until_ ? PairResult::kOk : PairResult::kClosed};
  }
  PairAnswer out{.result = PairResult::kWaiting, .key_id = attempts_.with_digits().said.key_id};
  wire::put_offer({.digits = *told, .role = asked_role(), .from = asked_from()}, out.value);
  return out;
}

bool PairingServer::may_begin(const PairRequest& request, PairingWay way) const noexcept {
  switch (request.method) {
    case PairMethod::kDigits:  // a press is for one key
      return is_open();
    case PairMethod::kCode:
      return code_.has_value();
    case PairMethod::kCable:
      return way == PairingWay::kCable;
    case PairMethod::kKey:
      return ring_.keys().find(request.key_id) != nullptr;
  }
  return false;
}

std::optional<std::span<const std::byte>> PairingServer::known(
    const Attempt& attempt) const noexcept {
  if (attempt.said.method == PairMethod::kCode && code_) {
    return *code_;
  }
  if (attempt.said.method != PairMethod::kKey) {
    return std::span<const std::byte>{};
  }
  const wire::Key* const key = ring_.keys().find(attempt.said.key_id);
  if (key != nullptr && mark_of(key->secret) == attempt.stands_on) {
    return key->secret;
  }
  if (key != nullptr && key->former && mark_of(*key->former) == attempt.stands_on) {
    return *key->former;
  }
  return std::nullopt;
}

PairingServer::Claim PairingServer::claim_of(const PairRequest& begin,
                                             PairingWay way) const noexcept {
  const auto shows = [&begin](std::span<const std::byte> known) {
    return wire::equal_secrets(std::as_bytes(std::span(begin.nonce)),
                               wire::begin_proof(known, begin));
  };
  const wire::Key* const key = ring_.keys().find(begin.key_id);
  if (begin.method == PairMethod::kKey && key != nullptr) {
    // A client that never got the last renewal's answer has the secret of before. So has one that
    // is older than the proof.
    const bool newest = shows(key->secret);
    const wire::Secret& secret = newest || !key->former ? key->secret : *key->former;
    return {.proven = newest || shows(secret), .stands_on = mark_of(secret)};
  }
  const bool holds = begin.method == PairMethod::kCable && way == PairingWay::kCable;
  return {.proven = holds || (begin.method == PairMethod::kCode && code_ && shows(*code_))};
}

PairAnswer PairingServer::begin(const PairRequest& request, PairingWay way, hal::Time now,
                                const hal::Peer& from) noexcept {
  if (!well_formed(request)) {
    return {.result = PairResult::kWrong};
  }
  if (!may_begin(request, way)) {
    return {.result = PairResult::kClosed};
  }
  const bool renews = request.method == PairMethod::kKey;
  if (!renews && ring_.keys().count() >= kMostKeys) {
    return {.result = PairResult::kFull};
  }
  if (needs_nobody(request.method) && !writes_.may_write(renews ? request.key_id : 0, now)) {
    return {.result = PairResult::kLater};
  }
  const Claim claim = claim_of(request, way);
  PairingAttempts::Place& place = attempts_.place_of(request.method, request.key_id, claim.proven);
  Attempt& attempt = place.attempt;
  const auto commitment = wire::bytes_in<wire::Digest>(request.value);
  if (attempt.phase != Phase::kNone && attempt.commitment == commitment) {
    return answer(attempt, PairResult::kOk);  // it was lost, or comes late
  }
  const bool digits = request.method == PairMethod::kDigits;
  const bool under_way = attempt.phase != Phase::kNone && attempt.phase != Phase::kDone;
  if (digits && attempt.phase != Phase::kNone) {  // nobody can tell which of the two is meant
    open_until_.reset();
    end(attempt);
    return {.result = PairResult::kBusy};
  }
  // Who has proven it begins anew: what he left, or another program of his.
  if ((under_way && !claim.proven) || !PairingAttempts::take_begin(place, now)) {
    return {.result = PairResult::kBusy};
  }
  end(attempt);
  attempt.phase = Phase::kBegun;
  attempt.number = random_number();
  attempt.from = from.address;
  attempt.stands_on = claim.stands_on;
  attempt.until = now + kKnownTime;
  attempt.commitment = commitment;
  attempt.said = {.sensor = sensor_,
                  .key_id = renews ? request.key_id : free_key_id(ring_.keys()),
                  .method = request.method,
                  .role = request.role,
                  .name = {}};
  std::ranges::copy(request.name, attempt.said.name.begin());
  attempt.said.sensor_key = attempt.has.emplace<wire::Exchange>().public_key();
  wire::fill_random(attempt.said.sensor_nonce);
  return answer(attempt, PairResult::kOk);
}

PairAnswer PairingServer::reveal(const PairRequest& request, Attempt& attempt) noexcept {
  wire::PairTranscript said = attempt.said;
  said.client_key = wire::bytes_in<wire::PublicKey>(request.value);
  said.client_nonce = wire::bytes_in<wire::PairNonce>(request.nonce);
  if (wire::commitment_of(said.client_key, said.client_nonce) != attempt.commitment) {
    return fail(attempt, PairResult::kWrong);
  }
  if (attempt.phase == Phase::kBegun) {
    const std::optional<wire::Secret> shared = attempt.exchange()->shared_with(said.client_key);
    const std::optional<std::span<const std::byte>> before = known(attempt);
    if (!shared || !before) {
      return fail(attempt, PairResult::kWrong);
    }
    attempt.said = said;
    attempt.has.emplace<wire::PairSecrets>(said, *shared, *before);
    attempt.phase = Phase::kRevealed;
  }
  PairAnswer out = answer(attempt, PairResult::kOk);
  out.value = {};
  wire::put_bytes(attempt.secrets()->sensor_tag(), out.value);
  return out;
}

PairAnswer PairingServer::confirm(const PairRequest& request, Attempt& attempt,
                                  hal::Time now) noexcept {
  const auto tag = wire::bytes_in<wire::Tag>(request.value);
  if (attempt.phase < Phase::kRevealed ||
      !wire::equal_secrets(tag, attempt.secrets()->client_tag())) {
    return fail(attempt, PairResult::kWrong);
  }
  if (attempt.phase == Phase::kRevealed) {
    attempt.phase = Phase::kProven;
  }
  if (attempt.said.method == PairMethod::kDigits && !accepted_) {
    return answer(attempt, PairResult::kWaiting);
  }
  if (attempt.phase == Phase::kProven && !known(attempt)) {
    return fail(attempt, PairResult::kWrong);  // the key got another secret, or its end, since
  }
  // Only who has proven what he knows uses it up.
  const bool renews = attempt.said.method == PairMethod::kKey;
  if (attempt.phase == Phase::kProven && needs_nobody(attempt.said.method) &&
      !writes_.take(renews ? attempt.said.key_id : 0, now)) {
    return fail(attempt, PairResult::kLater);
  }
  return finish(attempt);
}

// Both ends have agreed. Repeated, it says so again.
PairAnswer PairingServer::finish(Attempt& attempt) noexcept {
  if (attempt.phase == Phase::kDone) {
    if (ring_.keys().find(attempt.said.key_id) == nullptr) {
      return {.result = PairResult::kClosed};  // somebody has ended it since
    }
  } else {
    if (keep(attempt) != Status::kOk) {
      not_kept_ = attempt.number;
      return fail(attempt, PairResult::kFull);
    }
    attempt.phase = Phase::kDone;
    tell(attempt);
  }
  PairAnswer out = answer(attempt, PairResult::kOk);
  out.value = {};
  wire::put_bytes(attempt.secrets()->done_tag(), out.value);
  return out;
}

// A key that is renewed is there, with the secret that was shown: see confirm().
Status PairingServer::keep(const Attempt& attempt) noexcept {
  wire::Key key{.id = attempt.said.key_id,
                .device = sensor_.device_id,
                .role = attempt.said.role,
                .name = attempt.said.name,
                .secret = attempt.secrets()->secret()};
  Status kept = Status::kOk;
  if (attempt.said.method == PairMethod::kKey) {
    const bool newest = mark_of(ring_.keys().find(key.id)->secret) == attempt.stands_on;
    kept = ring_.replace(key.id, key.secret, newest ? Shown::kNewest : Shown::kFormer);
  } else {
    kept = ring_.add(key);
  }
  wire::wipe(key.secret);
  return kept;
}

void PairingServer::tell(const Attempt& attempt) noexcept {
  const wire::Key* const key = ring_.keys().find(attempt.said.key_id);
  if (changes_ != nullptr && key != nullptr) {
    static_cast<void>(changes_->push({.kind = attempt.said.method == PairMethod::kKey
                                                  ? firmware::EventKind::kKeyRenewed
                                                  : firmware::EventKind::kKeyMade,
                                      .value = key->id,
                                      .role = key->role,
                                      .address = attempt.from}));
  }
}

// Once there is a key nothing ends the attempt but time: whoever has made it must hear of it.
PairAnswer PairingServer::fail(Attempt& attempt, PairResult why) noexcept {
  if (attempt.phase == Phase::kDone) {
    return {.result = why};
  }
  if (attempt.said.method == PairMethod::kDigits) {
    open_until_.reset();
  }
  end(attempt);
  return {.result = why};
}

void PairingServer::end(Attempt& attempt) noexcept {
  const bool was_done = attempt.phase == Phase::kDone;
  attempt.end();
  if (&attempt == &attempts_.with_digits()) {
    if (told_at_ && !was_done) {
      cut_until_ = hal::Time::max();  // expire() knows the time
    }
    told_at_.reset();
    accepted_ = false;
  }
}

PairAnswer PairingServer::answer(const Attempt& attempt, PairResult result) noexcept {
  PairAnswer out{.result = result, .attempt = attempt.number, .key_id = attempt.said.key_id};
  wire::put_bytes(attempt.said.sensor_key, out.value);
  wire::put_bytes(attempt.said.sensor_nonce, out.nonce);
  return out;
}

}  // namespace stof::keys
