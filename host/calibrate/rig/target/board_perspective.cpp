#include "host/calibrate/rig/target/board_perspective.h"

#include <utility>

#include <opencv2/calib3d.hpp>

#include "dsp/base/index.h"
#include "dsp/calib/pmd/ray_table.h"
#include "host/calibrate/rig/target/lens_model.h"

namespace stof::host {
namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

// Where a lens that does not bend would show what this one shows at `found`; nothing comes from
// there where it cannot be.
std::optional<Vector2> straightened(const PixelPoint& found, const dsp::Pinhole* lens) {
  if (lens == nullptr) {
    return Vector2(found.u, found.v);
  }
  const std::array<double, 3> ray = dsp::unit_ray(*lens, found.u, found.v);
  if (!(ray[2] > 0)) {
    return std::nullopt;
  }
  return Vector2(lens->fx * ray[0] / ray[2] + lens->cx, lens->fy * ray[1] / ray[2] + lens->cy);
}

}  // namespace

BoardPerspective::BoardPerspective(Eigen::Matrix3d matrix, const dsp::Pinhole* lens)
    : matrix_(std::move(matrix)) {
  if (lens != nullptr) {
    lens_ = *lens;
  }
}

std::optional<BoardPerspective> BoardPerspective::through(const Board& board,
                                                          const std::vector<PixelPoint>& corners,
                                                          int fewest, const dsp::Pinhole* lens) {
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> in_picture;
  for (int i = 0; i < board.corners(); ++i) {
    const PixelPoint& corner = corners[dsp::index(i)];
    const std::optional<Vector2> place = corner.seen() ? straightened(corner, lens) : std::nullopt;
    if (place) {
      const std::array<double, 2> at = board.at(i);
      on_board.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]));
      in_picture.emplace_back(static_cast<float>(place->x()), static_cast<float>(place->y()));
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
  return BoardPerspective(matrix, lens);
}

Vector2 BoardPerspective::straight(const std::array<double, 2>& on_board) const {
  const Eigen::Vector3d place = matrix_ * Eigen::Vector3d(on_board[0], on_board[1], 1);
  return place.head<2>() / place.z();
}

Vector2 BoardPerspective::through_lens(const Vector2& straight) const {
  if (!lens_) {
    return straight;
  }
  const LensUnknowns lens = unknowns_of(*lens_);
  std::array<double, 2> pixel{};
  project(lens.data(),
          {(straight.x() - lens_->cx) / lens_->fx, (straight.y() - lens_->cy) / lens_->fy, 1.0},
          pixel);
  return {pixel[0], pixel[1]};
}

PixelPoint BoardPerspective::at(const std::array<double, 2>& on_board) const {
  const Vector2 place = through_lens(straight(on_board));
  return {.u = place.x(), .v = place.y()};
}

Matrix2 BoardPerspective::slope(const std::array<double, 2>& on_board) const {
  const Eigen::Vector3d place = matrix_ * Eigen::Vector3d(on_board[0], on_board[1], 1);
  const Vector2 at = place.head<2>() / place.z();
  Matrix2 slope =
      (matrix_.topLeftCorner<2, 2>() - at * matrix_.bottomLeftCorner<1, 2>()) / place.z();
  if (lens_) {
    constexpr double kStep = 0.5;  // px; distortion is smooth
    Matrix2 of_lens;
    of_lens.col(0) = through_lens(at + Vector2(kStep, 0)) - through_lens(at - Vector2(kStep, 0));
    of_lens.col(1) = through_lens(at + Vector2(0, kStep)) - through_lens(at - Vector2(0, kStep));
    slope = of_lens / (2 * kStep) * slope;
  }
  return slope;
}

Vector2 BoardPerspective::bend(const std::array<double, 2>& on_board, std::size_t axis,
                               double reach_m) const {
  if (!lens_) {
    return Vector2::Zero();
  }
  std::array<double, 2> before = on_board;
  std::array<double, 2> behind = on_board;
  before[axis] -= reach_m;
  behind[axis] += reach_m;
  const Vector2 first = through_lens(straight(before));
  const Vector2 last = through_lens(straight(behind));
  const double half = (last - first).norm() / 2;
  return (first + last - 2 * through_lens(straight(on_board))) / (half * half);
}

}  // namespace stof::host
