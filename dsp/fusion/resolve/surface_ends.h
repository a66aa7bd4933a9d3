#pragma once

#include <bit>
#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// What the left camera sees: its matches and its picture, which may be empty.
struct MatchedView {
  ImageView<const Disparity> disparity;
  ImageView<const std::uint8_t> picture = {};
};

// 16 times the logarithm to base 2, straight between powers of two. value: 1 or more.
constexpr int log2_q4(int value) noexcept {
  const int whole = static_cast<int>(std::bit_width(static_cast<unsigned>(value))) - 1;
  return whole * 16 + (((value << 4) >> whole) - 16);
}

// A pixel and how far the matches of its surface differ from its own, 1/16 px.
struct SurfacePixel {
  int x;
  int y;
  int raw;
  int most;
};

// What beyond_edge() says is within log2_q4() of this, to either side of 0.
inline constexpr int kFarthestBeyond = 128;

// Whether a match lies beyond the edge of its surface. Blocks and paths carry something near over
// what is beside it: then the edge that the picture shows lies between the match and its surface;
// else where the matches end.
//
// A surface ends to the left, to the right, above or below where the picture goes on, and one of
// the pixels 4 and 8 px away there has no match or one that differs by more than `most`. There the
// greatest step of grey from one pixel to the next, of 6 px back, is compared with that of 8 px on:
// log2_q4(4 + back) - log2_q4(4 + on). The greatest of all such ends: above 0 beyond an edge, below
// 0 before it; 0 where no end is near or there is no picture.
int beyond_edge(const MatchedView& view, const SurfacePixel& pixel) noexcept;

}  // namespace stof::dsp
