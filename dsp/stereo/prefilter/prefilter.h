#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// out[x] = clamp(S(x), -cap, cap) + cap, in 0..2 cap, with the horizontal Sobel derivative
// S(x) = D_above(x) + 2 D_here(x) + D_below(x), D_row(x) = row[x + 1] - row[x - 1]; the first and
// last column replicate. Four rows of equal length, any length, any alignment; out overlaps none.
// cap in 1..127. A cap of 15 leaves 5 bits and matches best (Sobel of both images in place of grey:
// Kuhnert & Stommel 2006, section 2.3).
using ClippedSobel = void(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                          std::span<const std::uint8_t> below, int cap,
                          std::span<std::uint8_t> out) noexcept;
STOF_KERNEL(ClippedSobel, clipped_sobel, kAvx2)

// The tail of a row for vector variants: columns [begin, end) as in clipped_sobel().
void clipped_sobel_columns(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                           std::span<const std::uint8_t> below, int cap, std::size_t begin,
                           std::size_t end, std::span<std::uint8_t> out) noexcept;

}  // namespace stof::dsp
