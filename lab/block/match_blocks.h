#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "lab/block/adaptive.h"
#include "lab/block/integral.h"
#include "lab/dsp_names.h"

// Winner takes all over blocks that differ from pixel to pixel (adaptive.h).
namespace stof::lab {

// The memory of match_blocks(), for pictures of exactly this size.
struct BlockOffers {
  // A right pixel is offered blocks of different areas: the mean is kept as a fraction.
  struct Offer {
    std::uint32_t sum;
    std::uint32_t area;  // 0: no offer yet
  };

  BlockOffers(int width, int height, Arena& arena) noexcept;
  void clear() const noexcept;

  Integral integral;
  ImageView<std::uint32_t> lowest;
  ImageView<std::uint32_t> highest;
  ImageView<Offer> offers;
  std::span<std::uint8_t> differences;  // one row
};

// winners = the candidate whose mean |left - right| over the block is lowest, the smallest of a
// tie; kNoWinner where the right image is not reached or no candidate costs more than another.
// Candidate i of pixel x is right column x - min_disparity - i, which lies inside the image; the
// other columns of its block replicate the border. right_winners: the same seen from the right
// pixel, among the candidates that left pixels offered with their blocks: the lowest mean cost.
// left, right: grey values or derivatives; all sizes equal. One pass over the image per candidate.
void match_blocks(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                  ImageView<const Block> blocks, int min_disparity, int disparities,
                  BlockOffers& best, ImageView<std::int16_t> winners,
                  ImageView<std::int16_t> right_winners) noexcept;

// The left-right check (left_right.h) on whole images: a winner whose match has another winner,
// farther off than `tolerance`, becomes kNoWinner.
void check_blocks(ImageView<const std::int16_t> right_winners, int min_disparity, int tolerance,
                  ImageView<std::int16_t> winners) noexcept;

}  // namespace stof::lab
