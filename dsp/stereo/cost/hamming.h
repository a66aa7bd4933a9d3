#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {

// costs[k][i] = the number of bits in which the census descriptors of left column k and of its
// candidate i differ. Layout of sad.h, n columns and lanes a multiple of 16: candidate i of column
// k is element n - 1 - k + i of the right row, which is reversed. Descriptors have `bits` bits,
// 24 (census 5x5 and 7x7) or 62 (9x7), in planes as census.h writes them: left is planes x n,
// right is planes x (n + lanes - 1). n at least 1, any alignment, costs overlap nothing.
using HammingCosts = void(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                          int bits, int lanes, std::span<std::uint8_t> costs) noexcept;
STOF_KERNEL(HammingCosts, hamming_costs, kAvx2)

}  // namespace stof::dsp
