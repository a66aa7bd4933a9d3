#include "dsp/stereo/search/sliding_blocks.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {

SlidingBlocks::SlidingBlocks(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params), width_(width), lanes_(lanes_of(params)) {
  STOF_CHECK(blocks_fit(params));
  columns_ =
      arena.take_passing<std::uint16_t>(index(width + params.block_width - 1) * index(lanes_));
  new_ = RowPair::take(params, width, arena);
  old_ = RowPair::take(params, width, arena);
}

void SlidingBlocks::start(const CostPictures& pictures) noexcept {
  STOF_CHECK(same_size(pictures.left, pictures.right) && pictures.left.width() <= width_);
  pictures_ = pictures;
  y_.reset();
}

// The column sums of row y.
void SlidingBlocks::begin(int y, std::span<std::uint16_t> columns) noexcept {
  const int above = params_.block_height / 2;
  std::ranges::fill(columns, std::uint16_t{0});
  for (int row = y - above; row < y - above + params_.block_height; ++row) {
    const RowPair rows = new_.load(pictures_, row, params_);
    best::add_differences(rows.left, rows.right, lanes_, columns);
  }
  for (std::uint16_t& sum : columns) {
    sum = static_cast<std::uint16_t>(sum * kBlockSumScale);
  }
}

void SlidingBlocks::row(int y, MarginScale margin, const BlockMatches& out) noexcept {
  STOF_CHECK(y >= 0 && y < pictures_.left.height());
  const std::span<std::uint16_t> columns =
      columns_.first(index(pictures_.left.width() + params_.block_width - 1) * index(lanes_));
  const int above = params_.block_height / 2;
  const bool slides = y_ && *y_ + 1 == y;
  if (!slides && y_ != y) {
    begin(y, columns);
  }
  // Where nothing slides the same pixels enter and leave.
  const RowPair entering =
      new_.load(pictures_, slides ? y + params_.block_height - 1 - above : y, params_);
  const RowPair leaving = slides ? old_.load(pictures_, y - 1 - above, params_) : entering;
  y_ = y;
  best::block_winners({.new_left = entering.left,
                       .new_right = entering.right,
                       .old_left = leaving.left,
                       .old_right = leaving.right},
                      {.block_width = params_.block_width,
                       .lanes = lanes_,
                       .disparities = params_.disparities,
                       .min_disparity = params_.min_disparity,
                       .x = 0,
                       .right_width = pictures_.left.width(),
                       .fit = cost_fit(params_.subpixel),
                       .margin = margin},
                      columns, out);
}

}  // namespace stof::dsp
