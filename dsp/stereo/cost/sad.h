#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "dsp/base/kernel.h"

// Absolute differences summed down the rows of a block, for all columns of a row and all
// candidates (column sums). The search begins with these sums and slides them itself from row to
// row (search/block_winners.h); the lab's block costs slide them by lab/cost/cost_sums.h.
//
// Layout. A row of n columns and `lanes` candidates is one array [column][candidate], lanes a
// multiple of 16. The right row is stored reversed, so that the candidates of a column are
// contiguous: column k meets candidate i at right[n - 1 - k + i]; right has n + lanes - 1 elements.
//
// Sums. u16 where w * h * (largest difference) < 65535, else u32 (64 * 64 * 255 = 1,044,480 fits).
namespace stof::dsp {

inline constexpr int kCostLanes = 16;

// Stands for "no candidate": right column outside the image, or lanes beyond the last candidate.
template <typename Sum>
inline constexpr Sum kNoCost = std::numeric_limits<Sum>::max();

// True when block sums of differences up to `largest_difference` stay below kNoCost of u16.
constexpr bool sums_fit_u16(int block_width, int block_height, int largest_difference) noexcept {
  return block_width * block_height * largest_difference < kNoCost<std::uint16_t>;
}
static_assert(sums_fit_u16(16, 16, 255) && !sums_fit_u16(17, 16, 255));
static_assert(sums_fit_u16(46, 46, 30) && !sums_fit_u16(64, 64, 30));

// columns[k][i] += |left[k] - right[n - 1 - k + i]|. No overlap, any alignment.
template <typename Sum>
using AddDifferences = void(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                            int lanes, std::span<Sum> columns) noexcept;

STOF_KERNELS(AddDifferences, add_differences, Neon<std::uint16_t>, Neon<std::uint32_t>)

}  // namespace stof::dsp
