#include "firmware/wire/crypto/crypto.h"

#include <sodium.h>

#include "dsp/base/check.h"
#include "firmware/wire/bytes.h"

namespace stof::wire {
namespace {

static_assert(sizeof(Secret) == crypto_scalarmult_SCALARBYTES);
static_assert(sizeof(PublicKey) == crypto_scalarmult_BYTES);
static_assert(sizeof(Secret) == crypto_generichash_KEYBYTES);
static_assert(sizeof(Tag) == crypto_generichash_BYTES_MIN);

const unsigned char* raw(std::span<const std::byte> bytes) noexcept {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

unsigned char* raw_space(std::span<std::byte> bytes) noexcept {
  return reinterpret_cast<unsigned char*>(bytes.data());
}

void blake2b(std::span<const std::byte> key, Parts parts, std::span<std::byte> out) noexcept {
  STOF_CHECK(key.size() <= crypto_generichash_KEYBYTES_MAX);
  crypto_generichash_state state;
  crypto_generichash_init(&state, key.empty() ? nullptr : raw(key), key.size(), out.size());
  for (const std::span<const std::byte> part : parts) {
    crypto_generichash_update(&state, raw(part), part.size());
  }
  crypto_generichash_final(&state, raw_space(out), out.size());
}

}  // namespace

bool start_crypto() noexcept { return sodium_init() >= 0; }

void fill_random(std::span<std::byte> bytes) noexcept {
  randombytes_buf(bytes.data(), bytes.size());
}

Tag tag_of(const Secret& secret, Parts parts) noexcept {
  Tag tag;
  blake2b(secret, parts, tag);
  return tag;
}

Tag counted_tag_of(const Secret& secret, std::uint64_t counter, Parts parts) noexcept {
  static_assert(sizeof(Tag) == crypto_onetimeauth_poly1305_BYTES);
  constexpr std::size_t kBlock = 16;
  std::array<std::byte, crypto_stream_chacha20_ietf_NONCEBYTES> nonce{};
  put_u64(std::span(nonce).last<8>(), counter);
  std::array<std::byte, crypto_onetimeauth_poly1305_KEYBYTES> once;
  crypto_stream_chacha20_ietf(raw_space(once), once.size(), raw(nonce), raw(secret));
  crypto_onetimeauth_poly1305_state state;
  crypto_onetimeauth_poly1305_init(&state, raw(once));
  std::size_t bytes = 0;
  for (const std::span<const std::byte> part : parts) {
    crypto_onetimeauth_poly1305_update(&state, raw(part), part.size());
    bytes += part.size();
  }
  // Zeros up to a whole block, then the lengths of additional data and plaintext.
  std::array<std::byte, 2 * kBlock> end{};
  const std::size_t zeros = (kBlock - bytes % kBlock) % kBlock;
  put_u64(std::span(end).subspan(zeros).first<8>(), bytes);
  crypto_onetimeauth_poly1305_update(&state, raw(end), zeros + kBlock);
  Tag tag;
  crypto_onetimeauth_poly1305_final(&state, raw_space(tag));
  return tag;
}

Digest digest_of(std::span<const std::byte> key, Parts parts) noexcept {
  Digest digest;
  blake2b(key, parts, digest);
  return digest;
}

namespace {

crypto_generichash_state& state_of(std::span<std::byte, sizeof(crypto_generichash_state)> bytes) {
  return *reinterpret_cast<crypto_generichash_state*>(bytes.data());
}

}  // namespace

void StreamingDigest::restart() noexcept {
  static_assert(sizeof(state_) == sizeof(crypto_generichash_state) &&
                alignof(StreamingDigest) >= alignof(crypto_generichash_state));
  crypto_generichash_init(&state_of(state_), nullptr, 0, sizeof(Digest));
}

void StreamingDigest::add(std::span<const std::byte> part) noexcept {
  crypto_generichash_update(&state_of(state_), raw(part), part.size());
}

Digest StreamingDigest::finish() noexcept {
  Digest digest;
  crypto_generichash_final(&state_of(state_), raw_space(digest), digest.size());
  return digest;
}

bool is_signed(const PublicKey& by, const Signature& signature,
               std::span<const std::byte> bytes) noexcept {
  static_assert(sizeof(Signature) == crypto_sign_ed25519_BYTES);
  static_assert(sizeof(PublicKey) == crypto_sign_ed25519_PUBLICKEYBYTES);
  return crypto_sign_ed25519_verify_detached(raw(signature), raw(bytes), bytes.size(), raw(by)) ==
         0;
}

bool equal_secrets(std::span<const std::byte> a, std::span<const std::byte> b) noexcept {
  STOF_CHECK(a.size() == b.size());
  return sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

void wipe(std::span<std::byte> bytes) noexcept { sodium_memzero(bytes.data(), bytes.size()); }

Exchange::Exchange() noexcept {
  fill_random(secret_);
  crypto_scalarmult_base(raw_space(public_), raw(secret_));
}

Exchange::Exchange(const Secret& secret) noexcept : secret_(secret) {
  crypto_scalarmult_base(raw_space(public_), raw(secret_));
}

std::optional<Secret> Exchange::shared_with(const PublicKey& other) const noexcept {
  Secret shared;
  if (crypto_scalarmult(raw_space(shared), raw(secret_), raw(other)) != 0) {
    return std::nullopt;
  }
  return shared;
}

}  // namespace stof::wire
