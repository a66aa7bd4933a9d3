#include "lab/block/adaptive.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>

#include "dsp/base/check.h"
#include "lab/block/integral.h"

namespace stof::lab {
namespace {

// The sides of a block in the order in which they grow.
enum Side : std::uint8_t { kLeft, kUp, kRight, kDown };

struct Extents {
  std::array<int, 4> reach{};  // px beyond the centre, by Side

  Block block() const noexcept {
    return {.left = static_cast<std::uint8_t>(reach[kLeft]),
            .right = static_cast<std::uint8_t>(reach[kRight]),
            .up = static_cast<std::uint8_t>(reach[kUp]),
            .down = static_cast<std::uint8_t>(reach[kDown])};
  }
};

// How far a block of `width` x `height` reaches about (x, y), inside the image.
Extents extents(int width, int height, int x, int y, int image_width, int image_height) noexcept {
  Extents out;
  out.reach[kLeft] = std::min(width / 2, x);
  out.reach[kRight] = std::min(width - 1 - width / 2, image_width - 1 - x);
  out.reach[kUp] = std::min(height / 2, y);
  out.reach[kDown] = std::min(height - 1 - height / 2, image_height - 1 - y);
  return out;
}

// Pixels that one step of a side adds, as columns and rows relative to the centre, both ends
// included. A cross looks along its arm only, a region at everything it would take in.
struct Strip {
  int left = 0;
  int right = 0;
  int up = 0;
  int down = 0;
};

Strip added(const Extents& now, Side side, BlockShape shape) noexcept {
  const int step = now.reach[side] + 1;
  const bool region = shape == BlockShape::kRegion;
  if (side == kLeft || side == kRight) {
    const int column = side == kLeft ? -step : step;
    return {column, column, region ? -now.reach[kUp] : 0, region ? now.reach[kDown] : 0};
  }
  const int row = side == kUp ? -step : step;
  return {region ? -now.reach[kLeft] : 0, region ? now.reach[kRight] : 0, row, row};
}

Block grow(const Integral& edges, int x, int y, const AdaptiveParams& params, int image_width,
           int image_height) noexcept {
  const Extents most =
      extents(params.max_width, params.max_height, x, y, image_width, image_height);
  if (params.shape == BlockShape::kFixed) {
    return most.block();
  }
  Extents now =
      extents(std::min(params.min_size, params.max_width),
              std::min(params.min_size, params.max_height), x, y, image_width, image_height);
  std::array<bool, 4> growing{true, true, true, true};
  while (std::ranges::any_of(growing, [](bool grows) { return grows; })) {
    for (const Side side : {kLeft, kUp, kRight, kDown}) {
      if (!growing[side]) {
        continue;
      }
      const Strip strip = added(now, side, params.shape);
      growing[side] =
          now.reach[side] < most.reach[side] &&
          edges.sum(x + strip.left, y + strip.up, x + strip.right + 1, y + strip.down + 1) == 0;
      now.reach[side] += growing[side] ? 1 : 0;
    }
  }
  return now.block();
}

}  // namespace

void mark_edges(ImageView<const std::uint8_t> grey, int edge,
                ImageView<std::uint8_t> edges) noexcept {
  STOF_CHECK(same_size(grey, edges) && edge >= 1 && edge <= 256);
  for (int y = 0; y < grey.height(); ++y) {
    const std::span<const std::uint8_t> above = grey.row_clamped(y - 1);
    const std::span<const std::uint8_t> here = grey.row(y);
    const std::span<const std::uint8_t> below = grey.row_clamped(y + 1);
    const std::span<std::uint8_t> out = edges.row(y);
    for (std::size_t x = 0; x < here.size(); ++x) {
      const int along = here[std::min(x + 1, here.size() - 1)] - here[x == 0 ? 0 : x - 1];
      const int across = below[x] - above[x];
      out[x] = std::max(std::abs(along), std::abs(across)) >= edge ? 1 : 0;
    }
  }
}

void grow_blocks(ImageView<const std::uint8_t> edges, const AdaptiveParams& params,
                 Integral& integral, ImageView<Block> blocks) noexcept {
  STOF_CHECK(same_size(edges, blocks) && params.max_width >= 1 && params.max_width <= kMaxBlock &&
             params.max_height >= 1 && params.max_height <= kMaxBlock && params.min_size >= 1);
  if (edges.empty()) {
    return;
  }
  for (int y = 0; y < edges.height(); ++y) {
    integral.add_row(edges.row(y), y);
  }
  for (int y = 0; y < blocks.height(); ++y) {
    for (int x = 0; x < blocks.width(); ++x) {
      blocks.at(x, y) = grow(integral, x, y, params, edges.width(), edges.height());
    }
  }
}

}  // namespace stof::lab
