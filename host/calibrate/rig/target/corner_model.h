#pragma once

#include <array>
#include <limits>
#include <optional>

#include <Eigen/Core>

#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/board_perspective.h"

// What a picture shows around a corner of a board: two edges that cross, smoothed by lens and
// pixels.
namespace stof::host {

// What is printed around a corner, metres on the board; the same in all four squares.
struct CornerPrint {
  double reach = 0;                                         // along an edge
  double inner = std::numeric_limits<double>::infinity();   // not so far from both edges
  double marker = std::numeric_limits<double>::infinity();  // where it begins in white squares
};
CornerPrint print_around_corners(const Board& board);

// How a corner's edges lie in a picture. Axis 0 crosses the edge between left and right squares,
// axis 1 that between upper and lower ones; black is where both count the same way.
struct CornerFrame {
  std::array<Eigen::Vector2d, 2> normal;
  // Of each edge: so far along it as s, the lens has bent it by bend s^2 / 2 along its normal;
  // 1/px.
  std::array<double, 2> bend{};
  std::array<double, 2> marker{};  // px from the edge
  std::array<double, 2> reach{};
  std::array<double, 2> inner{};

  // How much a pixel there counts, 0..1.
  double weight(const Eigen::Vector2d& from_corner) const;
};

// Of a corner of the board; even: its column and row are both even or both odd. nullopt: less than
// two pixels to the next edge, or seen from the side.
std::optional<CornerFrame> frame_of(const CornerPrint& print, const BoardPerspective& perspective,
                                    const std::array<double, 2>& on_board, bool even);

// How far a place is from an edge that is bent, px, and the slopes of that.
struct EdgeDistance {
  double value = 0;
  Eigen::Vector2d by_place;
  double by_turn = 0;  // of the normal, a radian
};
EdgeDistance distance_from(const Eigen::Vector2d& normal, double bend,
                           const Eigen::Vector2d& from_corner);

// Both edges as they are assumed to lie.
struct CornerEdges {
  std::array<Eigen::Vector2d, 2> normal;
  std::array<double, 2> marker{};  // as in the frame
  double blur = 0;                 // variance of the lens's Gaussian point spread, px^2
};

inline constexpr double kPixelVariance = 1.0 / 12;  // of a place within a pixel, px^2

// How white a pixel is, 0..1, so far from both edges; and the slopes of that.
struct White {
  double value = 0;
  double by_x = 0;
  double by_y = 0;
  double by_blur = 0;
};
White white_at(const CornerEdges& edges, double x, double y);

}  // namespace stof::host
