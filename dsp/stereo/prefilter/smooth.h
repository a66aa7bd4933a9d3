#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// out[x] = (V(x - 1) + 2 V(x) + V(x + 1) + 8) / 16, V(x) = above[x] + 2 here[x] + below[x]: the 3x3
// binomial, rounded half up; the first and last column replicate. Four rows of equal length, any
// length, any alignment; out overlaps none.
using Binomial = void(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                      std::span<const std::uint8_t> below, std::span<std::uint8_t> out) noexcept;
STOF_KERNEL(Binomial, binomial, kAvx2)

// The tail of a row for vector variants: columns [begin, end) as in binomial().
void binomial_columns(std::span<const std::uint8_t> above, std::span<const std::uint8_t> here,
                      std::span<const std::uint8_t> below, std::size_t begin, std::size_t end,
                      std::span<std::uint8_t> out) noexcept;

}  // namespace stof::dsp
