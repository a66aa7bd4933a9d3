#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/wire/codec/rvl_numbers.h"

// RVL, lossless coding of depth images (Wilson, "Fast Lossless Depth Image Compression", ISS 2017):
// runs of zeros and of other values in turn, differences of the latter, all as numbers of 3 bits a
// nibble. The layout is that of docs/WIRE.md, "RVL". T: std::uint8_t or std::uint16_t.
namespace stof::wire {

struct RvlCoded {
  std::size_t values = 0;  // coded, from the first on
  std::size_t bytes = 0;   // a multiple of 4
};

// Codes all values, or, where they do not fit `out` or are more than kMostRvlValues, as many of the
// first as do. A run that ends with `out` may waste up to 5 nibbles on its length.
template <typename T>
RvlCoded rvl_encode(std::span<const T> values, std::span<std::byte> out) noexcept;

// Where a sequence that was written on and on may end.
struct RvlCut {
  std::size_t values = 0;      // coded up to here; 0: none
  std::uint32_t nibbles = 0;   // of their code
  std::uint32_t count_at = 0;  // nibble where the length of the last run begins
  std::uint32_t count_nibbles = 0;
  std::uint32_t count = 0;  // of that run up to here
  bool zeros = false;       // it is one of zeros: that of the other values, 0, follows
};

struct RvlFit {
  RvlCut rows;  // after the last row that ends within `all`
  RvlCut all;   // after the last value that fits
};

// The same in two steps, so that a tile can end with a row: `out` holds a finished sequence after
// rvl_finish() of one of both cuts. The first row ends after `first_row` values, every other one
// after `row` more (both at least 1).
template <typename T>
RvlFit rvl_fit(std::span<const T> values, std::size_t first_row, std::size_t row,
               std::span<std::byte> out) noexcept;

// Bytes of the code that ends at `cut`, which rvl_finish() returns.
std::size_t rvl_bytes(const RvlCut& cut) noexcept;
std::size_t rvl_finish(const RvlCut& cut, std::span<std::byte> out) noexcept;

// Nibbles that the code of these values has at least, wherever they lie in a sequence: lengths of
// runs count as one nibble, where a run begins behind the first value.
template <typename T>
std::uint32_t rvl_least_nibbles(std::span<const T> values) noexcept;

}  // namespace stof::wire
