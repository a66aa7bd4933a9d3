#include "firmware/wire/keys/pair_secrets.h"

#include <string_view>

#include "firmware/wire/bytes.h"

namespace stof::wire {
namespace {

constexpr std::uint64_t kPossibleDigits = kDigitsEnd;

// Each digest has a purpose, so that none can stand for another.
std::span<const std::byte> purpose(std::string_view text) noexcept {
  return std::as_bytes(std::span(text));
}

Digest digest_of_transcript(const PairTranscript& said) noexcept {
  std::array<std::byte, 16> numbers{};
  const std::span<std::byte, 16> bytes(numbers);
  put_u32(bytes.subspan<0, 4>(), said.sensor.device_id);
  put_u32(bytes.subspan<4, 4>(), said.sensor.session_id);
  put_u32(bytes.subspan<8, 4>(), said.key_id);
  put_u8(bytes.subspan<12, 1>(), static_cast<std::uint8_t>(said.method));
  put_u8(bytes.subspan<13, 1>(), static_cast<std::uint8_t>(said.role));
  return digest_of(
      {}, {purpose("stof pairing 1 transcript"), numbers, std::as_bytes(std::span(said.name)),
           said.sensor_key, said.sensor_nonce, said.client_key, said.client_nonce});
}

}  // namespace

Digest commitment_of(const PublicKey& key, const PairNonce& nonce) noexcept {
  return digest_of({}, {purpose("stof pairing 1 commitment"), key, nonce});
}

PairNonce begin_proof(std::span<const std::byte> known, const PairRequest& begin) noexcept {
  std::array<std::byte, 16> numbers{};
  const std::span<std::byte, 16> bytes(numbers);
  put_u64(bytes.subspan<0, 8>(), begin.cookie);
  put_u32(bytes.subspan<8, 4>(), begin.key_id);
  put_u8(bytes.subspan<12, 1>(), static_cast<std::uint8_t>(begin.method));
  put_u8(bytes.subspan<13, 1>(), static_cast<std::uint8_t>(begin.role));
  const Digest digest = digest_of(
      known, {purpose("stof pairing 1 begin"), numbers, std::as_bytes(std::span(begin.name)),
              std::as_bytes(std::span(begin.value))});
  PairNonce proof{};
  std::ranges::copy(std::span(digest).first(proof.size()), proof.begin());
  return proof;
}

PairSecrets::PairSecrets(const PairTranscript& transcript, const Secret& shared,
                         std::span<const std::byte> known) noexcept
    : transcript_(digest_of_transcript(transcript)),
      master_(digest_of(known, {purpose("stof pairing 1 master"), shared, transcript_})) {}

std::uint32_t PairSecrets::digits() const noexcept {
  const Digest digest = digest_of({}, {purpose("stof pairing 1 digits"), transcript_});
  return static_cast<std::uint32_t>(get_u64(std::span(digest).first<8>()) % kPossibleDigits);
}

Tag PairSecrets::tag(const char* what) const noexcept {
  return tag_of(master_, {purpose(what), transcript_});
}

Tag PairSecrets::sensor_tag() const noexcept { return tag("stof pairing 1 sensor"); }
Tag PairSecrets::client_tag() const noexcept { return tag("stof pairing 1 client"); }
Tag PairSecrets::done_tag() const noexcept { return tag("stof pairing 1 done"); }

Secret PairSecrets::secret() const noexcept {
  return digest_of(master_, {purpose("stof pairing 1 key"), transcript_});
}

void put_offer(const PairOffer& offer, std::span<std::uint8_t, 32> value) noexcept {
  const std::span<std::byte, 32> bytes = std::as_writable_bytes(value);
  put_u32(bytes.first<4>(), offer.digits);
  put_u8(bytes.subspan<4, 1>(), static_cast<std::uint8_t>(offer.role));
  std::ranges::copy(offer.from, value.subspan<8, 16>().begin());
}

PairOffer offer_in(std::span<const std::uint8_t, 32> value) noexcept {
  PairOffer offer{.digits = get_u32(std::as_bytes(value).first<4>()),
                  .role = static_cast<Role>(value[4])};
  std::ranges::copy(value.subspan<8, 16>(), offer.from.begin());
  return offer;
}

void put_bytes(std::span<const std::byte> bytes, std::span<std::uint8_t> field) noexcept {
  std::ranges::copy(bytes, std::as_writable_bytes(field).begin());
}

}  // namespace stof::wire
