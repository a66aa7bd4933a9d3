#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/search/block_winners.h"

namespace stof::dsp {

// Rows of winner takes all on sums of absolute differences over fixed blocks, by the one pass of
// block_winners.h. Holds its buffers, allocates nothing. Sums slide from a row to the next one; any
// other row starts anew, at the price of block_height rows. The result does not depend on the
// order.
class SlidingBlocks {
 public:
  // For pictures up to `width`; blocks_fit(params).
  SlidingBlocks(const MatchParams& params, int width, Arena& arena) noexcept;

  // Another pair of derivatives, at most the constructor's width, that match prefilter_cap: values
  // stay below 2 cap + 1.
  void start(const CostPictures& pictures) noexcept;

  // Row y, inside the picture. margin, out: as block_winners() wants them, for the picture's width.
  void row(int y, MarginScale margin, const BlockMatches& out) noexcept;

 private:
  void begin(int y, std::span<std::uint16_t> columns) noexcept;

  MatchParams params_;
  int width_;
  int lanes_;
  std::span<std::uint16_t> columns_;
  RowPair new_;
  RowPair old_;

  CostPictures pictures_;
  std::optional<int> y_;  // the row that the sums stand for
};

}  // namespace stof::dsp
