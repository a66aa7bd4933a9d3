#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/search/tile_search.h"

namespace stof::dsp {

// A pair of equal size, as costs compare it and as coarser sizes are made from it.
struct PyramidPictures {
  ImageView<const std::uint8_t> left;  // the derivative with a prefilter_cap, else the grey values
  ImageView<const std::uint8_t> right;
  ImageView<const std::uint8_t> left_grey;
  ImageView<const std::uint8_t> right_grey;
};

// out(x, y) = the rounded mean of in(2 x .. 2 x + 1, 2 y .. 2 y + 1); borders replicate. Sizes
// halve, rounded up.
void halve(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) noexcept;

std::size_t pyramid_bytes_needed(const MatchParams& params, int width, int height) noexcept;

// Winner takes all on sums of absolute differences, coarse to fine: all candidates at the coarsest
// of params.pyramid_levels halved sizes; at each finer size a tile (tile_search.h) searches only
// around what its surroundings found before. A thing that the coarse pictures do not show is not
// found.
// With a prefilter and blocks of at least 8 px either way, neighbours having most of their block in
// common, only every second pixel of every second row is searched, and those between take a winner
// of their neighbours (pyramid_rows.h), first along rows. Where right winners are wanted each pixel
// of the finest size is searched.
// params: block, disparities, prefilter_cap and pyramid_levels count. winners: of the pictures'
// size; right empty where it is not wanted. arena: pyramid_bytes_needed() are scratch.
// Source: Sun 2002.
void match_coarse_to_fine(const MatchParams& params, const PyramidPictures& pictures, Arena arena,
                          const TileWinners& winners) noexcept;

}  // namespace stof::dsp
