#include "tests/fuzz/repeatable_keys.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>

using Bytes32 = std::array<unsigned char, 32>;

// The linker's names for what it wraps.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" {
int __real_crypto_scalarmult(unsigned char* q, const unsigned char* n, const unsigned char* p);
int __real_crypto_scalarmult_base(unsigned char* q, const unsigned char* n);
int __wrap_crypto_scalarmult(unsigned char* q, const unsigned char* n, const unsigned char* p);
int __wrap_crypto_scalarmult_base(unsigned char* q, const unsigned char* n);
void __wrap_randombytes_buf(void* buffer, std::size_t size);
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

namespace stof::fuzz {
namespace {

constexpr std::uint64_t mix(std::uint64_t value) noexcept {  // SplitMix64
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9U;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBU;
  return value ^ (value >> 31U);
}

class Numbers {
 public:
  void begin(std::uint64_t seed) noexcept {
    state_ = seed;
    secrets_ = 0;
  }
  std::uint64_t next() noexcept { return mix(state_ += 0x9E3779B97F4A7C15U); }
  std::size_t next_secret() noexcept { return secrets_++ % kSecrets; }

 private:
  std::uint64_t state_ = 0;
  std::size_t secrets_ = 0;
};

// Secrets, their public keys, and what each two of them have in common, once it was asked for.
class Curve {
 public:
  Curve() noexcept {
    for (std::size_t i = 0; i < kSecrets; ++i) {
      for (std::size_t at = 0; at < secrets_[i].size(); ++at) {
        secrets_[i][at] = static_cast<unsigned char>(mix(1 + i * secrets_[i].size() + at));
      }
      secrets_[i][kNumberAt] = static_cast<unsigned char>(i);
      __real_crypto_scalarmult_base(publics_[i].data(), secrets_[i].data());
    }
  }
  const Bytes32& secret(std::size_t number) const noexcept { return secrets_[number]; }
  const Bytes32& public_key(std::size_t number) const noexcept { return publics_[number]; }
  std::optional<std::size_t> number_of(const unsigned char* secret) const noexcept {
    const std::size_t number = secret[kNumberAt];
    const bool known =
        number < kSecrets && std::memcmp(secret, secrets_[number].data(), sizeof(Bytes32)) == 0;
    return known ? std::optional(number) : std::nullopt;
  }
  // nullptr: the point is nobody's public key.
  const Bytes32* shared(std::size_t number, const unsigned char* point) noexcept {
    const auto other = std::ranges::find_if(publics_, [point](const Bytes32& key) {
      return std::memcmp(key.data(), point, sizeof(Bytes32)) == 0;
    });
    if (other == publics_.end()) {
      return nullptr;
    }
    std::optional<Bytes32>& common =
        shared_[number][static_cast<std::size_t>(other - publics_.begin())];
    if (!common) {
      common.emplace();
      if (__real_crypto_scalarmult(common->data(), secrets_[number].data(), point) != 0) {
        common.reset();
        return nullptr;
      }
    }
    return &*common;
  }

 private:
  static constexpr std::size_t kNumberAt = 1;  // X25519 uses all bits of this byte

  std::array<Bytes32, kSecrets> secrets_{};
  std::array<Bytes32, kSecrets> publics_{};
  std::array<std::array<std::optional<Bytes32>, kSecrets>, kSecrets> shared_{};
};

constinit Numbers numbers;

Curve& curve() noexcept {
  static Curve one;
  return one;
}

}  // namespace

void begin_random(std::uint64_t seed) noexcept { numbers.begin(seed); }

}  // namespace stof::fuzz

int __wrap_crypto_scalarmult_base(unsigned char* q, const unsigned char* n) {
  using namespace stof::fuzz;
  const auto number = curve().number_of(n);
  if (!number) {
    return __real_crypto_scalarmult_base(q, n);
  }
  std::ranges::copy(curve().public_key(*number), q);
  return 0;
}

int __wrap_crypto_scalarmult(unsigned char* q, const unsigned char* n, const unsigned char* p) {
  using namespace stof::fuzz;
  const auto number = curve().number_of(n);
  const Bytes32* const shared = number ? curve().shared(*number, p) : nullptr;
  if (shared == nullptr) {
    return __real_crypto_scalarmult(q, n, p);
  }
  std::ranges::copy(*shared, q);
  return 0;
}

void __wrap_randombytes_buf(void* buffer, std::size_t size) {
  using namespace stof::fuzz;
  const std::span<unsigned char> bytes(static_cast<unsigned char*>(buffer), size);
  if (size == sizeof(Bytes32)) {
    std::ranges::copy(curve().secret(numbers.next_secret()), bytes.begin());
    return;
  }
  for (unsigned char& byte : bytes) {
    byte = static_cast<unsigned char>(numbers.next());
  }
}
