#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// Column sums of rows of u8 costs that are kept rather than computed again: add_differences() and
// slide_differences() of sad.h for every cost that is dear. Block sums follow with block_sums().
namespace stof::dsp {

// columns[j] += costs[j]. Equal lengths, a multiple of 16; no overlap, any alignment.
template <typename Sum>
using AddCosts = void(std::span<const std::uint8_t> costs, std::span<Sum> columns) noexcept;

// columns[j] += entering[j] - leaving[j]: one row enters the block, one leaves it.
template <typename Sum>
using SlideCosts = void(std::span<const std::uint8_t> entering,
                        std::span<const std::uint8_t> leaving, std::span<Sum> columns) noexcept;

STOF_KERNELS(AddCosts, add_costs, Neon<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(SlideCosts, slide_costs, Neon<std::uint16_t>, Neon<std::uint32_t>)

}  // namespace stof::dsp
