#pragma once

#include <cstdint>

// What makes a run of the pairing target repeatable, and cheap: random numbers that the input alone
// decides, and X25519 secrets out of a fixed number of them, so that what two of them have in
// common is computed once and then remembered. Every value is the library's own. Linked with --wrap
// for crypto_scalarmult, crypto_scalarmult_base and randombytes_buf.
namespace stof::fuzz {

// Random numbers begin anew; no two exchanges have one secret until kSecrets have begun.
void begin_random(std::uint64_t seed) noexcept;

inline constexpr unsigned kSecrets = 64;

}  // namespace stof::fuzz
