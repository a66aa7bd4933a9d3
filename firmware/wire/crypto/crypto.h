#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>

// What keys are made and used with, for both ends. crypto.cpp alone names the library that computes
// it (libsodium). Allocates nothing. For any thread once start_crypto() has returned.
namespace stof::wire {

using Secret = std::array<std::byte, 32>;  // of a client, or of one pairing
using Tag = std::array<std::byte, 16>;
using Digest = std::array<std::byte, 32>;
using PublicKey = std::array<std::byte, 32>;
using Parts = std::initializer_list<std::span<const std::byte>>;

// Before all else that is declared here, any number of times. false: this system cannot be used.
bool start_crypto() noexcept;

// Random bytes of the system. May wait once, early after a boot, until it has some.
void fill_random(std::span<std::byte> bytes) noexcept;

// Keyed BLAKE2b (RFC 7693) of 16 bytes over the parts, one behind the other: whoever knows the
// secret alone can make it. The parts' lengths are not told apart: have fixed ones.
Tag tag_of(const Secret& secret, Parts parts) noexcept;

// Keys of Poly1305 (RFC 8439, 2.5), each for one message: whoever makes two tags with one of them
// gives it away. They are 32 bytes each of the keystream of ChaCha20 (RFC 8439, 2.4, from block 0),
// two of a block of it; `high` and `low` are its nonce, little-endian. Many at once cost an eighth.
using OneTimeKey = std::array<std::byte, 32>;
void derive_one_time_keys(const Secret& secret, std::uint32_t high, std::uint64_t low,
                          std::span<OneTimeKey> keys) noexcept;
// The one at that place of them.
OneTimeKey one_time_key(const Secret& secret, std::uint32_t high, std::uint64_t low,
                        std::uint32_t place) noexcept;
// Poly1305 of the parts, one behind the other. Of a long message it costs a quarter of tag_of().
Tag one_time_tag(const OneTimeKey& key, Parts parts) noexcept;
// BLAKE2b of 32 bytes, with a key of at most 64 bytes; an empty one: without.
Digest digest_of(std::span<const std::byte> key, Parts parts) noexcept;

// digest_of() without a key, of bytes that come part by part.
class StreamingDigest {
 public:
  StreamingDigest() noexcept { restart(); }
  // Forgets what came.
  void restart() noexcept;
  void add(std::span<const std::byte> part) noexcept;
  // Of all that came since the last restart; then restart() before the next part.
  Digest finish() noexcept;

 private:
  alignas(64) std::array<std::byte, 384> state_{};
};

// Of Ed25519 (RFC 8032).
using Signature = std::array<std::byte, 64>;
// Whether whoever has the secret of that public key signed these bytes. For what is no point of the
// curve, or one with which anybody could: false.
bool is_signed(const PublicKey& by, const Signature& signature,
               std::span<const std::byte> bytes) noexcept;

// Whether the bytes are equal, in a time that does not tell where they differ. Of equal lengths.
bool equal_secrets(std::span<const std::byte> a, std::span<const std::byte> b) noexcept;
// Writes zeros that no compiler leaves out.
void wipe(std::span<std::byte> bytes) noexcept;

// One side of an X25519 exchange (RFC 7748), for once.
class Exchange {
 public:
  Exchange() noexcept;  // a random secret
  explicit Exchange(const Secret& secret) noexcept;
  ~Exchange() { wipe(secret_); }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  const PublicKey& public_key() const noexcept { return public_; }
  // What both sides know then, as the multiplication gives it: to be digested. None: the other side
  // sent a point with which anybody would know it.
  std::optional<Secret> shared_with(const PublicKey& other) const noexcept;

 private:
  Secret secret_;
  PublicKey public_{};
};

}  // namespace stof::wire
