#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

namespace stof::dsp {

// Cells of kCellSize x kCellSize pixels of a grey picture.
inline constexpr int kCellSize = 4;
using CellRows = std::array<std::span<const std::uint8_t>, kCellSize>;

// A cell has changed where its pixels differ by more than that: their sum (4 grey levels a pixel,
// five sigma of the sum of 16 differences with a noise of 3.3 each, which is that of a bright
// pixel), or one by one (9 a pixel, for what moves within the cell).
inline constexpr int kCellSumStep = 64;
inline constexpr int kCellPixelStep = 144;

// changed[i] = 255 where |sum now - sum then| > kCellSumStep or sum |now - then| > kCellPixelStep,
// sums over pixels 4 i .. 4 i + 3 of all rows, else 0. n elements of `changed`, rows of at least
// 4 n pixels, any alignment; no overlap.
using CellChange = void(const CellRows& now, const CellRows& then,
                        std::span<std::uint8_t> changed) noexcept;
STOF_KERNEL(CellChange, cell_change, kNeon)

// Lengths as above.
void check_cell_change(const CellRows& now, const CellRows& then,
                       std::span<const std::uint8_t> changed) noexcept;

}  // namespace stof::dsp
