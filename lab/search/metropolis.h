#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "lab/dsp_names.h"

// The Metropolis rule of simulated annealing in integers, so that every processor finds the same.
namespace stof::lab {

inline constexpr int kLogBits = 16;  // fraction bits of logarithms
inline constexpr int kTableBits = 8;

// log2(1 + (k + 1/2) / 2^kTableBits), bit by bit: squaring a number doubles its logarithm.
constexpr std::uint32_t fraction_log2(std::uint64_t k) noexcept {
  constexpr int kOneBits = 31;
  std::uint64_t value =
      (std::uint64_t{1} << kOneBits) + ((2 * k + 1) << (kOneBits - kTableBits - 1));
  std::uint32_t log = 0;
  for (int bit = 0; bit < kLogBits; ++bit) {
    value = (value * value) >> kOneBits;
    log *= 2;
    if (value >= std::uint64_t{2} << kOneBits) {
      value /= 2;
      ++log;
    }
  }
  return log;
}

inline constexpr std::array<std::uint32_t, 1U << kTableBits> kLog2 = [] {
  std::array<std::uint32_t, 1U << kTableBits> table{};
  for (std::size_t k = 0; k < table.size(); ++k) {
    table[k] = fraction_log2(k);
  }
  return table;
}();

// -log2 of a number uniform in (0, 1), 32 random bits of it: how many temperatures a rise may be.
inline std::uint64_t temperatures(std::uint32_t random) noexcept {
  const std::uint32_t bits = random | 1U;
  const int zeros = std::countl_zero(bits);
  const std::uint32_t mantissa = (bits << static_cast<unsigned>(zeros)) << 1U;
  const std::uint32_t log = kLog2[mantissa >> (32U - kTableBits)];
  return (static_cast<std::uint64_t>(zeros + 1) << kLogBits) - log;
}

}  // namespace stof::lab
