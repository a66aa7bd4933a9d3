#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// Column sums that slide from row to row, and block sums of them; layout and bounds as in
// dsp/stereo/cost/sad.h, where add_differences() is.
namespace stof::dsp {

// columns[k][i] += |new_left[k] - new_right[..]| - |old_left[k] - old_right[..]|: one row enters
// the block, one leaves it.
template <typename Sum>
using SlideDifferences = void(std::span<const std::uint8_t> new_left,
                              std::span<const std::uint8_t> new_right,
                              std::span<const std::uint8_t> old_left,
                              std::span<const std::uint8_t> old_right, int lanes,
                              std::span<Sum> columns) noexcept;

// costs[x][i] = sum over k = x .. x + block_width - 1 of columns[k][i], for n - block_width + 1
// columns x. No overlap.
template <typename Sum>
using BlockSums = void(std::span<const Sum> columns, int block_width, int lanes,
                       std::span<Sum> costs) noexcept;

// For rows of u8 costs that are kept, because it is dear to compute them again:
// columns[j] += costs[j]. Equal lengths, a multiple of 16; no overlap, any alignment.
template <typename Sum>
using AddCosts = void(std::span<const std::uint8_t> costs, std::span<Sum> columns) noexcept;

// columns[j] += entering[j] - leaving[j]: one row enters the block, one leaves it.
template <typename Sum>
using SlideCosts = void(std::span<const std::uint8_t> entering,
                        std::span<const std::uint8_t> leaving, std::span<Sum> columns) noexcept;

STOF_KERNELS(SlideDifferences, slide_differences, Neon<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(BlockSums, block_sums, Neon<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(AddCosts, add_costs, Neon<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(SlideCosts, slide_costs, Neon<std::uint16_t>, Neon<std::uint32_t>)

}  // namespace stof::dsp
