#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/index.h"

namespace stof::dsp {

// A PMD pixel that has a distance.
struct Reading {
  QuarterMm distance = kNoDepth;  // as if it had not wrapped
  QuarterMm sigma = 0;
  std::uint32_t amp2 = 0;  // at the reference integration time
};

inline constexpr int kMostWrapCounts = 7;

// In place of a wrap count.
inline constexpr std::int8_t kUnknownWraps = -1;   // nothing tells it
inline constexpr std::int8_t kDisputedWraps = -2;  // stereo and the readings around it differ
inline constexpr std::int8_t kRefutedWraps = -3;   // cannot be decided, or lies beyond max_range
inline constexpr std::int8_t kNoReading = -4;

// Whether bit k of pixel i is set.
inline bool has_bit(std::span<const std::uint16_t> bits, std::size_t i, int k) noexcept {
  return (bits[i] >> k) % 2 != 0;
}

// Findings about the pixels of a frame, row by row.
struct WrapMaps {
  WrapMaps(int columns, int lines, Arena& arena) noexcept : width(columns), height(lines) {
    readings = arena.take_passing<Reading>(pixels());
    vote = arena.take_passing<std::int8_t>(pixels());
    wraps = arena.take_passing<std::int8_t>(pixels());
    possible = arena.take_passing<std::uint16_t>(pixels());
    mixed = arena.take_passing<std::uint16_t>(pixels());
    bright = arena.take_passing<bool>(pixels());
    seen = arena.take_passing<bool>(pixels());
  }

  std::size_t pixels() const noexcept { return pixel_count(width, height); }
  std::size_t place(int x, int y) const noexcept { return pixel_count(width, y) + index(x); }
  // Where reading i lies if it wrapped k times, or beyond kMaxQuarterMm.
  std::uint32_t distance(std::size_t i, int k) const noexcept {
    return readings[i].distance + static_cast<std::uint32_t>(k) * range;
  }

  int width;
  int height;
  std::uint32_t range = 1;  // after how much readings repeat, quarter mm
  int wrap_counts = 1;      // 0 .. wrap_counts - 1 fit into u16; kMostWrapCounts at most
  std::span<Reading> readings;
  std::span<std::int8_t> vote;        // what amplitude or stereo says about this pixel alone
  std::span<std::int8_t> wraps;       // what is decided
  std::span<std::uint16_t> possible;  // bit k: k wraps stay within max_range, amplitude allows them
  std::span<std::uint16_t> mixed;     // bit k: much of what stereo sees there lies far off it
  std::span<bool> bright;             // amplitude alone proves that it has not wrapped
  std::span<bool> seen;               // stereo itself supports what is decided, and it wrapped
};

}  // namespace stof::dsp
