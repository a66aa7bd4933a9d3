#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// Rows of coarser pictures, and rows of winners (winner.h) of which every second one of every
// second row was searched.
namespace stof::dsp {

// out[x] = the rounded mean of two pixels above each other and the two to their right; the last
// column replicates. out: half as long, rounded up.
using HalveRow = void(std::span<const std::uint8_t> upper, std::span<const std::uint8_t> lower,
                      std::span<std::uint8_t> out) noexcept;

// Between the winners of two neighbours: the first one's where they differ by one candidate at
// most; across a step the smaller one, for a block that holds both surfaces mostly finds the
// nearer. Where one has no winner it is the other's.
// out: may be above or below, else no overlap.
using BetweenRows = void(std::span<const std::int16_t> above, std::span<const std::int16_t> below,
                         std::span<std::int16_t> out) noexcept;
// out[2 k] = found[k], the others between their neighbours; found: half as long, rounded up.
using SpreadRow = void(std::span<const std::int16_t> found, std::span<std::int16_t> out) noexcept;

STOF_KERNEL(HalveRow, halve_row, kNeon)
STOF_KERNEL(BetweenRows, between_rows, kNeon)
STOF_KERNEL(SpreadRow, spread_row, kNeon)

}  // namespace stof::dsp
