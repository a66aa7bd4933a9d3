#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"

// RVL, lossless coding of depth images (Wilson, "Fast Lossless Depth Image Compression", ISS 2017):
// runs of zeros and of other values in turn, differences of the latter, all as numbers of 3 bits a
// nibble. The layout is that of docs/WIRE.md, "RVL".
namespace stof::wire {

// Codes as many whole values as fit `out`, all of them if they fit. T: std::uint8_t or std::uint16_t.
struct RvlCoded {
  std::size_t values = 0;  // coded, from the first on
  std::size_t bytes = 0;   // a multiple of 4
};
template <typename T>
RvlCoded rvl_encode(std::span<const T> values, std::span<std::byte> out) noexcept;

// Any bytes; reads and writes nothing outside of them. kCorrupt: not the code of exactly
// values.size() values; what `values` holds then is undefined.
template <typename T>
Status rvl_decode(std::span<const std::byte> in, std::span<T> values) noexcept;

}  // namespace stof::wire
