#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/corner_finder.h"

namespace stof::host {

// Places of a board in a picture, as if the lens did not bend: the homography (Hartley and
// Zisserman, Multiple View Geometry, 2nd ed., 4.1) through the corners that are seen.
class BoardPerspective {
 public:
  // One place for each corner of the board, px. nullopt: fewer than `fewest`, at least 4, are seen,
  // or they lie on a line.
  static std::optional<BoardPerspective> through(const Board& board,
                                                 const std::vector<PixelPoint>& corners,
                                                 int fewest);

  // Of a place on the board, metres along rows and from row to row.
  PixelPoint at(const std::array<double, 2>& on_board) const;
  // Pixels a metre there: a column for each axis of the board.
  Eigen::Matrix2d slope(const std::array<double, 2>& on_board) const;

 private:
  // NOLINTNEXTLINE(modernize-pass-by-value): a matrix cannot be moved
  explicit BoardPerspective(const Eigen::Matrix3d& matrix) : matrix_(matrix) {}

  Eigen::Matrix3d matrix_;
};

}  // namespace stof::host
