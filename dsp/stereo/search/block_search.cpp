#include "dsp/stereo/search/block_search.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

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

bool BlockSearch::serves(const MatchParams& params) noexcept {
  return params.cost == Cost::kSad && params.method == Method::kWinnerTakesAll &&
         params.block_shape == BlockShape::kFixed && !params.interest && !params.pyramid_levels &&
         block_winners_serve(params.block_width, params.block_height, largest_difference(params));
}

std::size_t BlockSearch::bytes_needed(const MatchParams& params, int width) noexcept {
  const std::size_t left = size(width + params.block_width - 1);
  const std::size_t lanes = size(lanes_of(params));
  return Arena::bytes_for<std::uint16_t>(left * lanes) + 2 * Arena::bytes_for<std::uint8_t>(left) +
         2 * Arena::bytes_for<std::uint8_t>(left + lanes - 1);
}

BlockSearch::BlockSearch(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params), width_(width), lanes_(lanes_of(params)), around_(block_columns(params)) {
  STOF_CHECK(serves(params));
  const std::size_t left = size(width + params.block_width - 1);
  columns_ = arena.take<std::uint16_t>(left * size(lanes_));
  for (RowPair* const pair : {&new_, &old_}) {
    pair->left = arena.take<std::uint8_t>(left);
    pair->right = arena.take<std::uint8_t>(left + size(lanes_) - 1);
  }
}

void BlockSearch::start(const CostPictures& pictures) noexcept {
  STOF_CHECK(same_size(pictures.left, pictures.right) && pictures.left.width() <= width_);
  pictures_ = pictures;
  y_.reset();
}

std::size_t BlockSearch::widened() const noexcept {
  return size(pictures_.left.width() + params_.block_width - 1);
}

BlockSearch::RowPair BlockSearch::load(int y, const RowPair& buffers) const noexcept {
  const RowPair rows{buffers.left.first(widened()),
                     buffers.right.first(widened() + size(lanes_) - 1)};
  extend_row(pictures_.left.row_clamped(y), around_, rows.left);
  reverse_row(pictures_.right.row_clamped(y), around_, params_.min_disparity, rows.right);
  return rows;
}

// The column sums of row y.
void BlockSearch::begin(int y, std::span<std::uint16_t> columns) noexcept {
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

void BlockSearch::row(int y, const BlockMatches& out) noexcept {
  STOF_CHECK(y >= 0 && y < pictures_.left.height());
  const std::span<std::uint16_t> columns = columns_.first(widened() * size(lanes_));
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
