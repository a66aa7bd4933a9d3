#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

// How RVL writes one number.
namespace stof::wire {

// A number has at most 6 nibbles; one with fewer bits than its nibbles hold is legal.
inline constexpr unsigned kRvlNumberNibbles = 6;
// The most values of one sequence: a tile counts its pixels in 16 bits.
inline constexpr std::size_t kMostRvlValues = 65'535;

inline constexpr unsigned kRvlNibbleBits = 4;
inline constexpr unsigned kRvlWordNibbles = 8;
inline constexpr unsigned kRvlWordBits = 32;
inline constexpr std::size_t kRvlWordBytes = 4;

// The nibbles of a number, the first of them in the least significant bits: the other way round
// than a word of the code has them. rvl_turned() makes one from the other.
struct RvlPattern {
  std::uint32_t bits = 0;
  std::uint32_t nibbles = 0;
};
constexpr std::uint32_t rvl_turned(std::uint32_t word) noexcept {
  constexpr std::uint32_t kLowNibbles = 0x0F0F0F0F;
  const std::uint32_t bytes = std::byteswap(word);
  return ((bytes >> kRvlNibbleBits) & kLowNibbles) | ((bytes & kLowNibbles) << kRvlNibbleBits);
}
static_assert(rvl_turned(0x12345678) == 0x87654321);

// The number in `nibbles` nibbles, which hold it.
constexpr RvlPattern rvl_spread(std::uint32_t number, std::uint32_t nibbles) noexcept {
  constexpr std::uint32_t kGoesOn = 0x888888;
  const std::uint32_t pairs =
      (number & 0x3FU) | ((number & 0xFC0U) << 2) | ((number & 0x3F000U) << 4);
  const std::uint32_t bits = (pairs & 0x070707U) | ((pairs & 0x383838U) << 1);
  const std::uint32_t last = std::uint32_t{1} << (kRvlNibbleBits * (nibbles - 1));
  return {.bits = bits | (kGoesOn & (last - 1)), .nibbles = nibbles};
}
static_assert(rvl_spread(0b111'110'101'100'011'010, 6).bits == 0x7EDCBA);

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
