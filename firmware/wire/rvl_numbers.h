#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

// How RVL writes one number; for rvl_*.cpp alone.
namespace stof::wire {

inline constexpr unsigned kRvlNibbleBits = 4;
inline constexpr unsigned kRvlWordNibbles = 8;
inline constexpr unsigned kRvlWordBits = 32;
inline constexpr std::size_t kRvlWordBytes = 4;

// The nibbles of a number, the first of them in the most significant bits.
struct RvlPattern {
  std::uint32_t bits = 0;
  std::uint32_t nibbles = 0;
};

// The number in `nibbles` nibbles, which hold it.
constexpr RvlPattern rvl_spread(std::uint32_t number, std::uint32_t nibbles) noexcept {
  constexpr std::uint32_t kGoesOn = 8;
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < nibbles; ++i) {
    const std::uint32_t goes_on = i + 1 < nibbles ? kGoesOn : 0;
    const std::uint32_t nibble = ((number >> (3 * i)) & 7U) | goes_on;
    bits |= nibble << (kRvlNibbleBits * (kRvlWordNibbles - 1 - i));
  }
  return {.bits = bits, .nibbles = nibbles};
}

constexpr RvlPattern rvl_spread(std::uint32_t number) noexcept {
  return rvl_spread(number, (static_cast<std::uint32_t>(std::bit_width(number | 1U)) + 2) / 3);
}

// Differences by size, signs in turn: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
template <typename T>
std::uint32_t rvl_zigzag(T value, T before) noexcept {
  constexpr int kTop = 8 * sizeof(T) - 1;
  const auto difference = static_cast<T>(value - before);
  const auto sign = static_cast<T>(-(difference >> kTop));
  return static_cast<T>(static_cast<T>(difference << 1) ^ sign);
}

}  // namespace stof::wire
