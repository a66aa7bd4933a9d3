#include "dsp/stereo/map_search.h"

#include <algorithm>

#include "dsp/stereo/block/adaptive.h"
#include "dsp/stereo/search/pyramid.h"
#include "dsp/stereo/search/single_candidate.h"

namespace stof::dsp {
namespace {

bool has_shape(const MatchParams& params) noexcept {
  return params.block_shape != BlockShape::kFixed;
}

std::size_t pixels_of(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

void match_shapes(const MatchParams& params, const PreparedPair& pair, Arena arena,
                  ImageView<std::int16_t> winners, ImageView<std::int16_t> right) noexcept {
  const int width = winners.width();
  const int height = winners.height();
  const AdaptiveParams how{.shape = params.block_shape,
                           .max_width = params.block_width,
                           .max_height = params.block_height};
  const auto edges = arena.take_image<std::uint8_t>(width, height);
  const auto blocks = arena.take_image<Block>(width, height);
  mark_edges(pair.left_grey(), how.edge, edges);
  grow_blocks(edges, how, arena, blocks);
  match_blocks(pair.left(), pair.right(), blocks, params.min_disparity, params.disparities, arena,
               winners, right);
}

}  // namespace

bool searches_map(const MatchParams& params) noexcept {
  return has_shape(params) || params.pyramid_levels;
}

std::size_t search_map_bytes(const MatchParams& params, int width, int height) noexcept {
  const std::size_t pixels = pixels_of(width, height);
  const std::size_t right = Arena::bytes_for<std::int16_t>(pixels);
  if (!has_shape(params)) {
    return right + pyramid_bytes_needed(params, width, height);
  }
  return right + Arena::bytes_for<std::uint8_t>(pixels) + Arena::bytes_for<Block>(pixels) +
         std::max(grow_blocks_bytes(width, height), match_blocks_bytes(width, height));
}

void search_map(const MatchParams& params, const PreparedPair& pair, Arena arena,
                ImageView<std::int16_t> winners) noexcept {
  // Coarse to fine need not look at the right picture's winners where nobody asks for them.
  const bool check = params.left_right_tolerance.has_value();
  const auto right = has_shape(params) || check
                         ? arena.take_image<std::int16_t>(winners.width(), winners.height())
                         : ImageView<std::int16_t>();
  if (has_shape(params)) {
    match_shapes(params, pair, arena, winners, right);
  } else {
    match_coarse_to_fine(params,
                         {.left = pair.left(),
                          .right = pair.right(),
                          .left_grey = pair.left_grey(),
                          .right_grey = pair.right_grey()},
                         arena, {.left = winners, .right = right});
  }
  for (int y = 0; y < winners.height(); ++y) {
    settle_single_candidates(params.min_disparity, params.disparities, winners.row(y));
  }
  if (check) {
    check_blocks(right, params.min_disparity, *params.left_right_tolerance, winners);
  }
}

}  // namespace stof::dsp
