#pragma once

#include <cstdint>
#include <limits>

// Number formats of the frame path. Only this folder shifts by literals.
namespace stof::dsp {

// Round half up, then drop `bits` fraction bits: (value + 2^(bits-1)) >> bits. bits in 1..31.
template <typename T>
constexpr T round_shift(T value, int bits) noexcept {
  return static_cast<T>((value + (T{1} << (bits - 1))) >> bits);
}

// Disparity x_left - x_right in the left image: int16 with 4 fraction bits (1/16 px), or none.
// Range -2047.9375 .. 2047.9375 px.
struct Disparity {
  static constexpr int kFractionBits = 4;
  static constexpr std::int16_t kOne = 1 << kFractionBits;

  std::int16_t raw = std::numeric_limits<std::int16_t>::min();

  static constexpr Disparity none() noexcept { return {}; }
  static constexpr Disparity from_raw(std::int16_t raw) noexcept { return Disparity{raw}; }
  static constexpr Disparity from_pixels(int pixels) noexcept {
    return Disparity{static_cast<std::int16_t>(pixels * kOne)};
  }
  constexpr bool valid() const noexcept { return raw != std::numeric_limits<std::int16_t>::min(); }
  // Only for valid ones.
  constexpr float pixels() const noexcept { return static_cast<float>(raw) / kOne; }
  friend constexpr bool operator==(Disparity, Disparity) noexcept = default;
};
static_assert(sizeof(Disparity) == 2);

// Phase: 65536 is one turn; every sum wraps by itself and is never clipped.
using Phase = std::uint16_t;

// Distance, depth, sigma and interval width: u16 in quarter millimetres (0 .. 16.38 m).
// As a distance or depth 0 means none.
using QuarterMm = std::uint16_t;
inline constexpr QuarterMm kNoDepth = 0;
inline constexpr int kQuarterMmPerMetre = 4000;
inline constexpr QuarterMm kMaxQuarterMm = std::numeric_limits<QuarterMm>::max();

// Q15: 32768 is one. Components of unit vectors; 32767 stands for +1.
inline constexpr int kQ15Bits = 15;
inline constexpr int kQ15One = 1 << kQ15Bits;

}  // namespace stof::dsp
