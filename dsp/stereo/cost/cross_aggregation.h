#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// Mean cost over a cross-shaped region: for each pixel the rows of its vertical arms, each as far
// as that row's own horizontal arms reach. Three running sums make the work independent of the
// arms: along the row, down the columns, and the difference of two rows of the latter. All sums
// wrap at 65536: only differences are read, and those stay below it (area times largest cost).
//
// Rows are laid out [column][candidate] as in cost/sad.h, lanes a multiple of 16; n columns.
// Source: Zhang, Lu & Lafruit 2009, section III-B (orthogonal integral images).
namespace stof::dsp {

// sums[0] = 0, sums[x + 1] = sums[x] + costs[x]: n + 1 columns.
using SumAlong = void(std::span<const std::uint8_t> costs, int lanes,
                      std::span<std::uint16_t> sums) noexcept;

// below[x] = above[x] + sums[x + right[x] + 1] - sums[x - left[x]]. `sums` of sum_along(); n =
// left.size(); above and below may be the same memory.
using SumDown = void(std::span<const std::uint16_t> sums, std::span<const std::uint8_t> left,
                     std::span<const std::uint8_t> right, int lanes,
                     std::span<const std::uint16_t> above, std::span<std::uint16_t> below) noexcept;

// The two rows of sum_down() that bound a pixel's vertical arms, and one divided by its area, Q16:
// min(32767, round(65536 / area)), so that a region of one pixel alone would count half.
struct CrossEnds {
  const std::uint16_t* above;  // ends with the row before the arm's first
  const std::uint16_t* below;  // ends with the arm's last row
  std::int16_t reciprocal;
};

// means[x] = min(255, (sum / 2 * reciprocal + 2^14) / 2^15) with sum = below - above, all divisions
// rounding down, of n = ends.size() columns; above and below point at column 0 of their rows.
using CrossMeans = void(std::span<const CrossEnds> ends, int lanes,
                        std::span<std::uint8_t> means) noexcept;

STOF_KERNEL(SumAlong, sum_along, kAvx2)
STOF_KERNEL(SumDown, sum_down, kAvx2)
STOF_KERNEL(CrossMeans, cross_means, kAvx2)

}  // namespace stof::dsp
