#pragma once

#include <cstdint>

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

}  // namespace stof::lab
