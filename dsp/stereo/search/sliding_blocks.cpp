#include "dsp/stereo/search/sliding_blocks.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {
namespace {

CostFit fit_of(const MatchParams& params) noexcept {
  switch (params.subpixel) {
    case Subpixel::kEquiangular:
      return CostFit::kEquiangular;
    case Subpixel::kParabola:
      return CostFit::kParabola;
    case Subpixel::kWhole:
    case Subpixel::kLeastSquares:
      break;
  }
  return CostFit::kNone;
}

}  // namespace

SlidingBlocks::SlidingBlocks(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params), width_(width), lanes_(lanes_of(params)), around_(block_columns(params)) {
  STOF_CHECK(blocks_fit(params));
  const std::size_t left = index(width + params.block_width - 1);
  columns_ = arena.take<std::uint16_t>(left * index(lanes_));
  for (RowPair* const pair : {&new_, &old_}) {
    pair->left = arena.take<std::uint8_t>(left);
    pair->right = arena.take<std::uint8_t>(left + index(lanes_) - 1);
  }
}

void SlidingBlocks::start(const CostPictures& pictures) noexcept {
  STOF_CHECK(same_size(pictures.left, pictures.right) && pictures.left.width() <= width_);
  pictures_ = pictures;
  y_.reset();
}

std::size_t SlidingBlocks::widened() const noexcept {
  return index(pictures_.left.width() + params_.block_width - 1);
}

SlidingBlocks::RowPair SlidingBlocks::load(int y, const RowPair& buffers) const noexcept {
  const RowPair rows{buffers.left.first(widened()),
                     buffers.right.first(widened() + index(lanes_) - 1)};
  extend_row(pictures_.left.row_clamped(y), around_, rows.left);
  reverse_row(pictures_.right.row_clamped(y), around_, params_.min_disparity, rows.right);
  return rows;
}

// The column sums of row y.
void SlidingBlocks::begin(int y, std::span<std::uint16_t> columns) noexcept {
  const int above = params_.block_height / 2;
  std::ranges::fill(columns, std::uint16_t{0});
  for (int row = y - above; row < y - above + params_.block_height; ++row) {
    const RowPair rows = load(row, new_);
    best::add_differences(rows.left, rows.right, lanes_, columns);
  }
  for (std::uint16_t& sum : columns) {
    sum = static_cast<std::uint16_t>(sum * kBlockSumScale);
  }
}

void SlidingBlocks::row(int y, const BlockMatches& out) noexcept {
  STOF_CHECK(y >= 0 && y < pictures_.left.height());
  const std::span<std::uint16_t> columns = columns_.first(widened() * index(lanes_));
  const int above = params_.block_height / 2;
  const bool slides = y_ && *y_ + 1 == y;
  if (!slides && y_ != y) {
    begin(y, columns);
  }
  // Where nothing slides the same pixels enter and leave.
  const RowPair entering = load(slides ? y + params_.block_height - 1 - above : y, new_);
  const RowPair leaving = slides ? load(y - 1 - above, old_) : entering;
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
                       .fit = fit_of(params_)},
                      columns, out);
}

}  // namespace stof::dsp
