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

using Nonce = std::array<std::byte, crypto_stream_chacha20_ietf_NONCEBYTES>;

Nonce nonce_of(std::uint32_t high, std::uint64_t low) noexcept {
  Nonce nonce;
  put_u32(std::span(nonce).first<4>(), high);
  put_u64(std::span(nonce).last<8>(), low);
  return nonce;
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

void derive_one_time_keys(const Secret& secret, std::uint32_t high, std::uint64_t low,
                          std::span<OneTimeKey> keys) noexcept {
  const Nonce nonce = nonce_of(high, low);
  const std::span<std::byte> space = std::as_writable_bytes(keys);
  crypto_stream_chacha20_ietf(raw_space(space), space.size(), raw(nonce), raw(secret));
}

OneTimeKey one_time_key(const Secret& secret, std::uint32_t high, std::uint64_t low,
                        std::uint32_t place) noexcept {
  const Nonce nonce = nonce_of(high, low);
  std::array<OneTimeKey, 2> block{};
  const std::span<std::byte> space = std::as_writable_bytes(std::span(block));
  crypto_stream_chacha20_ietf_xor_ic(raw_space(space), raw(space), space.size(), raw(nonce),
                                     place / 2, raw(secret));
  return block[place % 2];
}

Tag one_time_tag(const OneTimeKey& key, Parts parts) noexcept {
  static_assert(sizeof(Tag) == crypto_onetimeauth_poly1305_BYTES);
  static_assert(sizeof(OneTimeKey) == crypto_onetimeauth_poly1305_KEYBYTES);
  crypto_onetimeauth_poly1305_state state;
  crypto_onetimeauth_poly1305_init(&state, raw(key));
  for (const std::span<const std::byte> part : parts) {
    crypto_onetimeauth_poly1305_update(&state, raw(part), part.size());
  }
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
  if (a.size() == crypto_verify_16_BYTES) {  // a third of the general one's time
    return crypto_verify_16(raw(a), raw(b)) == 0;
  }
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
