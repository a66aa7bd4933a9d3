#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "lab/block/integral.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

// Blocks that adapt to the picture: grown from a small block until they meet an edge, up to a
// maximum. Small where something begins or ends, large where nothing does.
// Source: Kuhnert & Stommel 2006, section 2.2.
namespace stof::lab {

// A block about a pixel: columns x - left .. x + right, rows y - up .. y + down, all inside the
// image.
struct Block {
  std::uint8_t left = 0;
  std::uint8_t right = 0;
  std::uint8_t up = 0;
  std::uint8_t down = 0;
  constexpr int width() const noexcept { return left + 1 + right; }
  constexpr int height() const noexcept { return up + 1 + down; }
  friend constexpr bool operator==(Block, Block) noexcept = default;
};

struct AdaptiveParams {
  // kCross: arms grow from the small block along the row and the column of the centre.
  // kRegion: whole columns and rows are added, in turn left, up, right, down, each while what it
  // adds holds no edge. kFixed: the maximum, cut at the image's borders.
  BlockShape shape = BlockShape::kRegion;
  int max_width = 60;   // px, 1..64
  int max_height = 20;  // px, 1..64
  int min_size = 9;     // px: width and height of the block to begin with; it may hold edges
  int edge = 20;        // grey levels, for mark_edges()
};

// edges[x] = 1 where the grey value changes by at least `edge` between x - 1 and x + 1 or between
// y - 1 and y + 1 (borders replicate), else 0. edge 1..256; 256 marks nothing.
void mark_edges(ImageView<const std::uint8_t> grey, int edge,
                ImageView<std::uint8_t> edges) noexcept;

// The block of every pixel. edges: 1 or 0; equal sizes. integral: scratch of that size.
void grow_blocks(ImageView<const std::uint8_t> edges, const AdaptiveParams& params,
                 Integral& integral, ImageView<Block> blocks) noexcept;

// What match_blocks() works in, for pictures of exactly this size.
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
