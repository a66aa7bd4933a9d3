#pragma once

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"

// A depth map of fewer pixels that hides no obstacle: each block of step x step pixels (less at
// the right and lower border) is represented by the pixel with the nearest lower bound,
// depth - width / 2.
namespace stof::dsp {

inline constexpr int kLeastBlock = 1;
inline constexpr int kMostBlock = 64;

constexpr int decimated(int pixels, int step) noexcept { return (pixels + step - 1) / step; }

struct NearestPixel {
  int x = 0;  // in the map
  int y = 0;
  QuarterMm depth = kNoDepth;
  QuarterMm width = 0;
};

// The pixel of block (column, row) with the smallest 2 * depth - width among those with a depth;
// of equal ones the first in raster order. Without any, depth and width are 0.
// step: kLeastBlock to kMostBlock; the block begins inside the map.
NearestPixel nearest_pixel(const DepthMap& map, int step, int column, int row) noexcept;

// The same of every block. `depth` and `width` have decimated(map width, step) x
// decimated(map height, step) pixels; no overlap with the map.
void decimate(const DepthMap& map, int step, ImageView<QuarterMm> depth,
              ImageView<QuarterMm> width) noexcept;

}  // namespace stof::dsp
