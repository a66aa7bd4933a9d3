#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// Census descriptors of one row: a bit for every neighbour in a window, set where the neighbour is
// darker than the centre. Borders replicate. Source: Zabih & Woodfill 1994.
//
// Bits are numbered along the rows of the window from its top left neighbour, the centre left out:
// 0..23 in 5x5, 0..61 in 9x7 (9 columns, 7 rows). In 7x7 every second neighbour counts, as the dark
// fields of a chess board whose centre is a light one: 0..23. They see as far as all 48 do, and as
// well (docs/DESIGN.md).
//
// Layout: planes[p][x], p-th byte of all columns beside each other: bit b is place b % kPlaneBits
// of plane b / kPlaneBits; places beyond the last bit are 0. Sixteen candidates of a plane are one
// vector, which is what hamming.h wants.
namespace stof::dsp {

// Odd sizes in px, and which neighbours count.
struct CensusWindow {
  std::size_t width;
  std::size_t height;
  bool chessboard;  // every second neighbour alone

  constexpr std::size_t cells() const noexcept { return width * height; }
  constexpr int bits() const noexcept {
    return static_cast<int>(chessboard ? cells() / 2 : cells() - 1);
  }
  // The neighbour that a bit stands for, counted along the rows of the window.
  constexpr std::size_t cell(std::size_t bit) const noexcept {
    if (chessboard) {
      return 2 * bit + 1;
    }
    return bit < cells() / 2 ? bit : bit + 1;  // steps over the centre
  }
};
inline constexpr CensusWindow kCensus5x5{5, 5, false};
inline constexpr CensusWindow kCensus7x7{7, 7, true};
inline constexpr CensusWindow kCensus9x7{9, 7, false};

// Planes of a descriptor of so many bits.
constexpr std::size_t planes_of(int bits) noexcept {
  return static_cast<std::size_t>((bits + kPlaneBits - 1) / kPlaneBits);
}

// rows: the window's rows from top to bottom, the middle one being described; n columns each, any
// length, any alignment. planes: planes_of(bits) * n bytes, overlapping no row.
template <std::size_t kRows>
using Census = void(std::span<const std::span<const std::uint8_t>, kRows> rows,
                    std::span<std::uint8_t> planes) noexcept;

STOF_KERNEL(Census<5>, census_5x5, kAvx2)
STOF_KERNEL(Census<7>, census_7x7, kAvx2)
STOF_KERNEL(Census<7>, census_9x7, kAvx2)

}  // namespace stof::dsp
