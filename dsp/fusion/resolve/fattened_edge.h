#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace stof::dsp {

// The farthest that matches of something near are looked at beside its left edge, px.
inline constexpr std::size_t kEdgeBand = 8;
// What its true edge differs by from one pixel to the next, grey levels.
inline constexpr int kEdgeStep = 24;
// The step of disparity that an edge has at least, of the nearer parallax.
inline constexpr int kCutShare = 20;

// Matches of a near surface reach beyond its left edge: a block or a path holds the edge, so it
// fits the pixels before it as well. Where the picture's edge is tells how far.
//
// A row of the left picture, in which the surface behind was last matched at left_at and the near
// one first at right_at. Of the steps from right_at - 1 to right_at + kEdgeBand, the greatest, if
// it is at least kEdgeStep, is the edge (the first of equal ones).
class FattenedEdge {
 public:
  FattenedEdge(std::span<const std::uint8_t> picture, std::size_t left_at,
               std::size_t right_at) noexcept;

  // Pixels right_at .. end() - 1 lie before the edge; end() is right_at where there are none.
  std::size_t end() const noexcept { return end_; }
  // Whether pixel x looks like the last three pixels at left_at rather than the three behind the
  // edge, clearly: two and a half times as much.
  bool is_behind(std::size_t x) const noexcept;

 private:
  std::span<const std::uint8_t> picture_;
  std::size_t end_;
  int behind_ = 0;  // sums of three pixels
  int near_ = 0;
};

}  // namespace stof::dsp
