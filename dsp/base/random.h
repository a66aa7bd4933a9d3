#pragma once

#include <cstdint>

// Random numbers that are the same bits on every machine; std's distributions are not.
namespace stof::dsp {

// A well mixed 64-bit word of another (the finaliser of splitmix64).
constexpr std::uint64_t mix(std::uint64_t x) noexcept {
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBU;
  return x ^ (x >> 31U);
}

inline constexpr std::uint64_t kSplitMixStep = 0x9E3779B97F4A7C15U;

// splitmix64.
class SplitMix64 {
 public:
  constexpr explicit SplitMix64(std::uint64_t seed) noexcept : state_(seed) {}
  constexpr std::uint64_t next() noexcept { return mix(state_ += kSplitMixStep); }

 private:
  std::uint64_t state_;
};

}  // namespace stof::dsp
