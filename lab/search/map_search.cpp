#include "lab/search/map_search.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/refine/least_squares.h"
#include "dsp/stereo/refine/subpixel.h"
#include "dsp/stereo/search/border_columns.h"

namespace stof::lab {

bool MapSearch::serves(const MatchParams& params) noexcept {
  return params.block_shape != BlockShape::kFixed || params.pyramid_levels;
}

MapSearch::MapSearch(const MatchParams& params, int width, int height, Arena& arena) noexcept
    : params_(params), winners_(arena.take_image<std::int16_t>(width, height)) {
  STOF_CHECK(serves(params));
  const bool check = params.left_right_tolerance.has_value();
  if (params.block_shape != BlockShape::kFixed) {
    shapes_.emplace(width, height, arena);
  } else {
    pyramid_.emplace(params, check, width, height, arena);
  }
  if (shapes_ || check) {
    right_ = arena.take_image<std::int16_t>(width, height);
  }
}

void MapSearch::start(const PreparedPair& pair, Guide guide) noexcept {
  STOF_CHECK(guide.empty() && same_size(pair.left_grey(), winners_));
  pair_ = &pair;
  searched_ = false;
}

void MapSearch::match(int y, const MatchedRow& out) noexcept {
  if (!searched_) {
    search();
  }
  best::refine_winners(std::span<const std::uint16_t>(), 0, CostFit::kNone, params_.min_disparity,
                       std::span<const std::int16_t>(winners_.row(y)), out.disparity);
  if (params_.subpixel == Subpixel::kLeastSquares) {
    best::refine_least_squares(pair_->left_grey(), pair_->right_grey(), y, params_.block_width,
                               params_.block_height, out.disparity);
  }
  std::ranges::fill(out.ratio, kRatioUnknown);
}

void MapSearch::search() noexcept {
  searched_ = true;
  if (shapes_) {
    match_shapes(*pair_);
  } else {
    pyramid_->match({.left = pair_->left(),
                     .right = pair_->right(),
                     .left_grey = pair_->left_grey(),
                     .right_grey = pair_->right_grey()},
                    {.left = winners_, .right = right_});
  }
  for (int y = 0; y < winners_.height(); ++y) {
    match_border_columns(params_.min_disparity, params_.disparities, winners_.row(y));
  }
  if (params_.left_right_tolerance) {
    check_blocks(right_, params_.min_disparity, *params_.left_right_tolerance, winners_);
  }
}

void MapSearch::match_shapes(const PreparedPair& pair) noexcept {
  const AdaptiveParams how{.shape = params_.block_shape,
                           .max_width = params_.block_width,
                           .max_height = params_.block_height};
  mark_edges(pair.left_grey(), how.edge, shapes_->edges);
  grow_blocks(shapes_->edges, how, shapes_->offers.integral, shapes_->blocks);
  match_blocks(pair.left(), pair.right(), shapes_->blocks, params_.min_disparity,
               params_.disparities, shapes_->offers, winners_, right_);
}

}  // namespace stof::lab
