#include "host/calibrate/rig/target/board_perspective.h"

#include <opencv2/calib3d.hpp>

#include "dsp/base/index.h"

namespace stof::host {

std::optional<BoardPerspective> BoardPerspective::through(const Board& board,
                                                          const std::vector<PixelPoint>& corners,
                                                          int fewest) {
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> in_picture;
  for (int i = 0; i < board.corners(); ++i) {
    const PixelPoint& corner = corners[dsp::index(i)];
    if (corner.seen()) {
      const std::array<double, 2> at = board.at(i);
      on_board.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]));
      in_picture.emplace_back(static_cast<float>(corner.u), static_cast<float>(corner.v));
    }
  }
  if (on_board.size() < dsp::index(fewest)) {
    return std::nullopt;
  }
  const cv::Mat found = cv::findHomography(on_board, in_picture);
  if (found.empty()) {
    return std::nullopt;
  }
  Eigen::Matrix3d matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      matrix(row, column) = found.at<double>(row, column);
    }
  }
  return BoardPerspective(matrix);
}

PixelPoint BoardPerspective::at(const std::array<double, 2>& on_board) const {
  const Eigen::Vector3d place = matrix_ * Eigen::Vector3d(on_board[0], on_board[1], 1);
  return {.u = place.x() / place.z(), .v = place.y() / place.z()};
}

Eigen::Matrix2d BoardPerspective::slope(const std::array<double, 2>& on_board) const {
  const Eigen::Vector3d place = matrix_ * Eigen::Vector3d(on_board[0], on_board[1], 1);
  const Eigen::Matrix<double, 2, 1> at = place.head<2>() / place.z();
  return (matrix_.topLeftCorner<2, 2>() - at * matrix_.bottomLeftCorner<1, 2>()) / place.z();
}

}  // namespace stof::host
