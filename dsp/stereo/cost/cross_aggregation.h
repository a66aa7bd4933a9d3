#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
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

// A row's sums and those of the rows above and below it, n columns each. Column x takes part of
// `above` and `below` where with_above[x] and with_below[x] are 1, else 0; what it takes is the
// costs of areas[x] pixels, whose reciprocal is Q15 and not negative.
struct CrossRows {
  std::span<const std::uint8_t> above;
  std::span<const std::uint8_t> here;
  std::span<const std::uint8_t> below;
  std::span<const std::uint8_t> with_above;
  std::span<const std::uint8_t> with_below;
  std::span<const std::uint8_t> areas;        // below reciprocals.size()
  std::span<const std::int16_t> reciprocals;  // by area
};

// means[x] = min(255, (sum reciprocals[areas[x]] + 2^14) >> 15) of n columns, sum: of those rows
// that take part.
using CrossMeans = void(const CrossRows& rows, int lanes, std::span<std::uint8_t> means) noexcept;

STOF_KERNEL(SumAlike, sum_alike, kAvx2)
STOF_KERNEL(CrossMeans, cross_means, kAvx2)

// Checks the sizes of cross_means, for its variants.
inline void check_cross_rows(const CrossRows& rows, int lanes, std::size_t means) noexcept {
  const std::size_t n = rows.areas.size();
  STOF_CHECK(lanes > 0 && means == n * static_cast<std::size_t>(lanes));
  STOF_CHECK(rows.above.size() == means && rows.here.size() == means && rows.below.size() == means);
  STOF_CHECK(rows.with_above.size() == n && rows.with_below.size() == n);
}

}  // namespace stof::dsp
