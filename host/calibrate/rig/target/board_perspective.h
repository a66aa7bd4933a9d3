#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "dsp/calib/pinhole.h"
#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/corner_finder.h"

namespace stof::host {

// Places of a board in a picture: the homography (Hartley and Zisserman, Multiple View Geometry,
// 2nd ed., 4.1) through the corners that are seen, and behind it the lens, where that is known;
// else as if it did not bend.
class BoardPerspective {
 public:
  // One place for each corner of the board, px. nullopt: fewer than `fewest`, at least 4, are seen,
  // or they lie on a line.
  static std::optional<BoardPerspective> through(const Board& board,
                                                 const std::vector<PixelPoint>& corners, int fewest,
                                                 const dsp::Pinhole* lens = nullptr);

  // Of a place on the board, metres along rows and from row to row.
  PixelPoint at(const std::array<double, 2>& on_board) const;
  // Pixels a metre there: a column for each axis of the board.
  Eigen::Matrix2d slope(const std::array<double, 2>& on_board) const;
  // How a line along that axis of the board bends there: its second derivative by its length in the
  // picture, 1/px, from places `reach_m` to both sides.
  Eigen::Vector2d bend(const std::array<double, 2>& on_board, std::size_t axis,
                       double reach_m) const;

 private:
  BoardPerspective(Eigen::Matrix3d matrix, const dsp::Pinhole* lens);
  Eigen::Vector2d straight(const std::array<double, 2>& on_board) const;
  Eigen::Vector2d through_lens(const Eigen::Vector2d& straight) const;

  Eigen::Matrix3d matrix_;
  std::optional<dsp::Pinhole> lens_;
};

}  // namespace stof::host
