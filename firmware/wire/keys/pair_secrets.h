#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/keys/key_table.h"
#include "firmware/wire/messages/pair_answer.h"
#include "firmware/wire/messages/pair_request.h"
#include "firmware/wire/messages/structs.h"

// What both ends of a pairing compute: see "Pairing" of docs/WIRE.md.
namespace stof::wire {

using PairNonce = std::array<std::byte, 16>;
inline constexpr std::uint32_t kDigitsEnd = 1'000'000;  // all digits are below it

// What the client binds itself to before it sees anything of the sensor's.
Digest commitment_of(const PublicKey& key, const PairNonce& nonce) noexcept;

// In the nonce of begin, of methods code and key: that whoever begins knows what both know. cookie,
// method, role, key id, name and value of the request count.
PairNonce begin_proof(std::span<const std::byte> known, const PairRequest& begin) noexcept;

// What both have said.
struct PairTranscript {
  Origin sensor{};
  std::uint32_t key_id = 0;
  PairMethod method = PairMethod::kDigits;
  Role role = Role::kNone;
  std::array<char, kKeyNameBytes> name{};
  PublicKey sensor_key{};
  PairNonce sensor_nonce{};
  PublicKey client_key{};
  PairNonce client_nonce{};
};

// What only they can know then, and whoever sits between them does not.
class PairSecrets {
 public:
  // shared: of the exchange. known: what both knew before, the label's code or the key's secret;
  // empty: nothing.
  PairSecrets(const PairTranscript& transcript, const Secret& shared,
              std::span<const std::byte> known) noexcept;
  ~PairSecrets() { wipe(master_); }
  PairSecrets(const PairSecrets&) = default;
  PairSecrets& operator=(const PairSecrets&) = default;

  // Below kDigitsEnd: equal for both, unless somebody is between them, whose luck is one in a
  // million.
  std::uint32_t digits() const noexcept;
  Tag sensor_tag() const noexcept;  // the sensor has the same secrets
  Tag client_tag() const noexcept;  // the client too, and its user wants the key
  Tag done_tag() const noexcept;    // the sensor has the key
  Secret secret() const noexcept;   // of the key

 private:
  Tag tag(const char* what) const noexcept;

  Digest transcript_;
  Secret master_;
};

// What whoever accepts the digits at the sensor agrees to: in the answer `waiting` to who holds the
// cable.
struct PairOffer {
  std::uint32_t digits = 0;
  Role role = Role::kNone;              // that the key gets; kNone: of a sensor that does not tell
  std::array<std::uint8_t, 16> from{};  // who began, as in hal::Peer; all 0: over the cable
};
void put_offer(const PairOffer& offer, std::span<std::uint8_t, 32> value) noexcept;
PairOffer offer_in(std::span<const std::uint8_t, 32> value) noexcept;

// Of a field of the messages, which begins with them, and back.
template <typename Bytes>
Bytes bytes_in(std::span<const std::uint8_t> field) noexcept {
  Bytes bytes{};
  std::ranges::copy(std::as_bytes(field.first(bytes.size())), bytes.begin());
  return bytes;
}
void put_bytes(std::span<const std::byte> bytes, std::span<std::uint8_t> field) noexcept;

}  // namespace stof::wire
