#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// Mean cost over the smallest cross-shaped region: of a pixel and of the pixels above and below it
// that look like it, each with those to its left and right that look like that one. So a mean of
// 3x3 pixels that ends at edges. Two steps: along the rows, then across them.
//
// Rows are laid out [column][candidate] as in cost/sad.h, lanes a multiple of 16; n columns. Costs
// are at most 85, so that three of them fit u8. Source: Zhang, Lu & Lafruit 2009, with arms of one
// pixel.
namespace stof::dsp {

inline constexpr int kLargestAggregatedInput = 85;

// sums[x] = costs[x] + joined[x] costs[x - 1] + joined[x + 1] costs[x + 1], where joined[x], 0 or
// 1, tells whether columns x - 1 and x look alike: n + 1 of them, the first and the last 0.
using SumAlike = void(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> joined,
                      int lanes, std::span<std::uint8_t> sums) noexcept;

// One pixel's input from the rows above and below: its own lanes of their sums, or of zeros.
struct CrossColumn {
  const std::uint8_t* above;
  const std::uint8_t* below;
  std::int16_t reciprocal;  // Q15, of the pixels of the region: not negative
};

// means[x] = min(255, ((above + here + below) reciprocal + 2^14) >> 15) of n columns; here: the
// sums of the row itself.
using CrossMeans = void(std::span<const CrossColumn> columns, std::span<const std::uint8_t> here,
                        int lanes, std::span<std::uint8_t> means) noexcept;

STOF_KERNEL(SumAlike, sum_alike, kAvx2)
STOF_KERNEL(CrossMeans, cross_means, kAvx2)

}  // namespace stof::dsp
