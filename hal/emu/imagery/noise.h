#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/random.h"

namespace stof::hal::emu {

// xorshift64*: fast, good enough for sensor noise.
class Xorshift64 {
 public:
  constexpr explicit Xorshift64(std::uint64_t seed) noexcept
      : state_(dsp::SplitMix64(seed).next() | 1U) {}
  constexpr std::uint64_t next() noexcept {
    state_ ^= state_ >> 12U;
    state_ ^= state_ << 25U;
    state_ ^= state_ >> 27U;
    return state_ * 0x2545F4914F6CDD1DULL;
  }

 private:
  std::uint64_t state_;
};

// The standard normal distribution as a table: entry i is its quantile (i + 1/2) / 4096 with
// kGaussianBits fraction bits, so that a random index gives a normal number (within +-3.7 sigma).
inline constexpr std::size_t kGaussianSize = 4096;
inline constexpr int kGaussianBits = 12;
const std::array<std::int16_t, kGaussianSize>& gaussian_table() noexcept;

// Normal numbers, kGaussianBits fraction bits, four from each random word.
class GaussianNoise {
 public:
  explicit GaussianNoise(std::uint64_t seed) noexcept : random_(seed), table_(gaussian_table()) {}
  std::int32_t next() noexcept {
    if (left_ == 0) {
      word_ = random_.next();
      left_ = 4;
    }
    --left_;
    const std::int32_t value = table_[word_ % kGaussianSize];
    word_ >>= 16U;
    return value;
  }

 private:
  Xorshift64 random_;
  const std::array<std::int16_t, kGaussianSize>& table_;
  std::uint64_t word_ = 0;
  int left_ = 0;
};

}  // namespace stof::hal::emu
