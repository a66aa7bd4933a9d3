#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/control/access.h"
#include "firmware/keys/keyring.h"
#include "firmware/wire/keys/signed_packet.h"

namespace stof::keys {

// Judges who signed a packet, and that nobody sends it a second time: the counters of a key only
// rise in this session, which the tag is of. For the thread of the keyring; no heap.
class Authenticator {
 public:
  enum class Verdict : std::uint8_t {
    kGood,
    kForged,    // of no key that is here, or not signed with it
    kReplayed,  // signed, but its counter is no higher than one that was
  };
  struct Signer {
    Verdict verdict = Verdict::kForged;
    const wire::Key* key = nullptr;  // but for kForged; until the keyring changes
    bool former = false;             // with the secret from before it was renewed
    std::uint64_t highest = 0;       // of its counters, this one among them
  };

  // The keyring outlives it.
  explicit Authenticator(Keyring& ring) noexcept : ring_(ring) {}

  // Whether somebody whose packet is of this session (the caller's matter) is who he says. A good
  // one's counter is used up; the first of a renewed secret ends the one of before, which may block
  // for as long as saving a file takes.
  Signer judge(const wire::SignedView& packet) noexcept;

  // Of whoever can sign.
  const wire::KeyTable& keys() const noexcept { return ring_.keys(); }
  // Whether anybody can sign.
  bool knows_keys() const noexcept { return ring_.pairing() == Pairing::kPaired; }
  // Of whoever signs nothing.
  firmware::Access unsigned_access() const noexcept {
    return ring_.pairing() == Pairing::kUnpaired ? firmware::Access::kHarmless
                                                 : firmware::Access::kRead;
  }

 private:
  struct Counter {
    std::uint32_t key_id = 0;  // 0: nobody's
    std::uint64_t highest = 0;
  };
  Counter& counter_of(std::uint32_t key_id) noexcept;

  Keyring& ring_;
  std::array<Counter, kMostKeys> counters_{};
};

}  // namespace stof::keys
