#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/refine/subpixel.h"
#include "dsp/stereo/search/winner.h"
#include "dsp/stereo/validation/winner_margin.h"

// Winner takes all on sums of absolute differences over blocks, with the fit of the costs, in one
// pass over a row: column sums slide by a row of pixels, block sums stay in registers, and the sums
// themselves need not be kept. Equal to sad.h summed along the row, then winner.h and then
// subpixel.h.
//
// Sums are eight times the sums of differences. Their low three bits then number groups of eight
// candidates, so that the minimum itself tells which group it comes from, and of a tie is the group
// of the smaller candidates. Margins (validation/winner_margin.h) come of the same pass.
namespace stof::dsp {

inline constexpr int kBlockSumScale = 8;
// A cost with the number of its candidate's group, as sums have it; kNoCost remains.
constexpr std::uint16_t numbered_cost(std::uint16_t cost, int candidate) noexcept {
  return cost == kNoCost<std::uint16_t>
             ? cost
             : static_cast<std::uint16_t>(kBlockSumScale * cost + candidate / 8 % 8);
}
constexpr std::uint16_t cost_of_numbered(std::uint16_t numbered) noexcept {
  return numbered == kNoCost<std::uint16_t> ? numbered : numbered / kBlockSumScale;
}
// The largest sum of a block: eight times it and the number of a group fit u16, below the value for
// no candidate; so does the largest number of the fit, 8.5 times a difference of sums.
inline constexpr int kLargestBlockSum = 7710;
// The largest pixel: differences have a sign and seven bits.
inline constexpr int kLargestBlockPixel = 127;

constexpr bool block_winners_serve(int block_width, int block_height, int largest_pixel) noexcept {
  return largest_pixel <= kLargestBlockPixel &&
         block_width * block_height * largest_pixel <= kLargestBlockSum;
}
static_assert(block_winners_serve(16, 16, 30) && block_winners_serve(15, 15, 30));

// Pixels that enter a block's column sums and that leave them: n columns, layout of sad.h.
struct BlockPixels {
  std::span<const std::uint8_t> new_left;
  std::span<const std::uint8_t> new_right;
  std::span<const std::uint8_t> old_left;
  std::span<const std::uint8_t> old_right;
};

// Where the n - block_width + 1 columns of a row lie, and what they may match.
struct BlockRow {
  int block_width = 1;
  int lanes = 0;          // a multiple of 16, at most 256
  int disparities = 0;    // candidates, at most lanes
  int min_disparity = 0;  // of candidate 0
  int x = 0;              // of the first column
  int right_width = 0;    // right columns 0 .. right_width - 1 can be met
  CostFit fit = CostFit::kNone;
  MarginScale margin = {};
};

struct BlockMatches {
  std::span<std::int16_t> winners;  // one for each column
  std::span<Disparity> fitted;      // as refine_winners() of these winners
  // Empty, or the costs as sad.h has them, kNoCost where there is no candidate. Up to
  // kBlockCostMargin elements before and behind them are read.
  std::span<std::uint16_t> costs;
  // Empty, or what winner_margins() finds of these winners and costs; not without costs.
  std::span<std::int16_t> margins = {};
  // Whether `costs` are numbered_cost() each, of which the search makes no others.
  bool numbered = false;
};
inline constexpr int kBlockCostMargin = 32;  // a cache line

// columns: n x lanes, kBlockSumScale times the column sums of the row before; then of this row.
using BlockWinners = void(const BlockPixels& pixels, const BlockRow& row,
                          std::span<std::uint16_t> columns, const BlockMatches& out) noexcept;
STOF_KERNEL(BlockWinners, block_winners, kAvx512)

}  // namespace stof::dsp
