#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Subpixel disparity from grey values, for row y. Where disparities[x] is valid, with d its whole
// part (rounded, halves up), g the left picture, f the right one moved by d and g' the derivative
// of g along the row (px^-1), over a block about x:
//   s = sum g' (f - g) / sum g'^2,   disparities[x] = 16 d + 16 s (rounded, halves away from 0).
// |s| > 1/2 means that the match is wrong: dropped, none. Without any derivative s = 0. f(x) =
// R(x - d) = g(x + s), so s adds to d. Block as everywhere, x - floor(w/2) .. x + w - 1 -
// floor(w/2), w, h in 1..64; borders replicate. Grey values, not clipped derivatives: the pictures
// must agree in brightness. |disparities| below 2047 px. Source: Kuhnert & Stommel 2006, eq. 10 and
// 11, whose sign is corrected here.
using RefineLeastSquares = void(ImageView<const std::uint8_t> left,
                                ImageView<const std::uint8_t> right, int y, int block_width,
                                int block_height, std::span<Disparity> disparities) noexcept;
STOF_KERNEL(RefineLeastSquares, refine_least_squares, kNeon)

// 16 d + 16 s, or none, from sums over the block of G (f - g) and G^2, G = g(x + 1) - g(x - 1):
// s = 2 moment / energy. |moment|, energy < 2^29.
Disparity shifted_disparity(int whole, std::int32_t moment, std::int32_t energy) noexcept;
// One pixel, for the ends of vector variants.
Disparity least_squares_at(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                           int x, int y, int block_width, int block_height,
                           Disparity disparity) noexcept;

}  // namespace stof::dsp
