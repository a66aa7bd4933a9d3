#include "host/client/session/stream_verifier.h"

#include <algorithm>
#include <optional>

namespace stof::client {

void StreamVerifier::set_key(const wire::StreamKey& key, std::uint32_t session) {
  Known& newest = known_.front();
  const wire::StreamKey& had = newest.tagger.key();
  if (key.number == had.number && wire::equal_secrets(key.secret, had.secret)) {
    return;
  }
  // The same number again is of a sensor that started again.
  known_.back() = key.number == had.number || session != session_ ? Known{} : newest;
  session_ = session;
  newest = {.tagger = wire::StreamTagger(key)};
}

// A sensor that starts again counts its keys from 1 again.
StreamVerifier::Verdict StreamVerifier::judge(std::span<const std::byte> datagram,
                                              std::uint32_t session) {
  const std::optional<wire::StreamSignature> signature = wire::signature_of(datagram);
  const auto known =
      signature && session == session_
          ? std::ranges::find_if(
                known_,
                [&](const Known& one) { return one.tagger.key().number == signature->number; })
          : known_.end();
  if (known == known_.end()) {
    return signature && awaits_key_ ? Verdict::kKeyToCome : Verdict::kNotSigned;
  }
  const std::uint64_t counter = signature->counter;
  // What costs little comes first: a repetition is not worth a tag.
  if (counter <= known->highest) {
    if (known->highest - counter >= kWindow) {
      return Verdict::kLate;
    }
    if (known->seen.test(counter % kWindow)) {
      return Verdict::kDuplicate;
    }
  }
  if (!wire::signed_with(known->tagger, *signature, datagram)) {
    return Verdict::kForged;
  }
  known->tagger.keep(counter);  // who cannot sign moves nothing
  known->use(counter);
  ++good_;
  good_number_ = signature->number;
  return Verdict::kGood;
}

void StreamVerifier::Known::use(std::uint64_t counter) {
  if (counter > highest) {
    if (counter - highest >= kWindow) {
      seen.reset();
    } else {
      for (std::uint64_t skipped = highest + 1; skipped < counter; ++skipped) {
        seen.reset(skipped % kWindow);
      }
    }
    highest = counter;
  }
  seen.set(counter % kWindow);
}

}  // namespace stof::client
