#include "host/calibrate/rig/target/board_pose.h"

#include <cmath>
#include <utility>

#include <opencv2/calib3d.hpp>

namespace stof::host {
namespace {

constexpr std::size_t kFewestViews = 3;

// Those corners of a board that are seen.
struct SeenPoints {
  std::vector<cv::Point3f> on_board;
  std::vector<cv::Point2f> in_picture;
};

SeenPoints seen_points(const Board& board, const std::vector<PixelPoint>& corners) {
  SeenPoints points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i].seen()) {
      const std::array<double, 2> at = board.at(static_cast<int>(i));
      points.on_board.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]), 0.0F);
      points.in_picture.emplace_back(static_cast<float>(corners[i].u),
                                     static_cast<float>(corners[i].v));
    }
  }
  return points;
}

bool is_lens(const dsp::Pinhole& lens) {
  const double longest = 100.0 * std::max(lens.width, lens.height);
  return std::isfinite(lens.cx) && std::isfinite(lens.cy) && lens.fx > 1 && lens.fx < longest &&
         lens.fy > 1 && lens.fy < longest && std::abs(lens.k1) < 10 && std::abs(lens.k2) < 100;
}

}  // namespace

std::optional<PoseUnknowns> pose_of_board(const Board& board,
                                          const std::vector<PixelPoint>& corners,
                                          const dsp::Pinhole& lens) {
  const cv::Matx33d matrix(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  const cv::Vec<double, 5> distortion(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
  const SeenPoints points = seen_points(board, corners);
  cv::Vec3d turn;
  cv::Vec3d shift;
  try {
    if (!cv::solvePnP(points.on_board, points.in_picture, matrix, distortion, turn, shift)) {
      return std::nullopt;
    }
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  if (!(shift[2] > 0)) {
    return std::nullopt;
  }
  return PoseUnknowns{turn[0], turn[1], turn[2], shift[0], shift[1], shift[2]};
}

std::optional<dsp::Pinhole> lens_of_views(const Board& board,
                                          const std::vector<std::vector<PixelPoint>>& views,
                                          int width, int height) {
  if (views.size() < kFewestViews) {
    return std::nullopt;
  }
  std::vector<std::vector<cv::Point3f>> points;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const std::vector<PixelPoint>& view : views) {
    SeenPoints seen = seen_points(board, view);
    points.push_back(std::move(seen.on_board));
    pixels.push_back(std::move(seen.in_picture));
  }
  cv::Mat matrix = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat distortion = cv::Mat::zeros(5, 1, CV_64F);
  std::vector<cv::Mat> turns;
  std::vector<cv::Mat> shifts;
  try {
    cv::calibrateCamera(points, pixels, cv::Size(width, height), matrix, distortion, turns, shifts,
                        cv::CALIB_FIX_K3 | cv::CALIB_ZERO_TANGENT_DIST);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  dsp::Pinhole lens{.width = width,
                    .height = height,
                    .fx = matrix.at<double>(0, 0),
                    .fy = matrix.at<double>(1, 1),
                    .cx = matrix.at<double>(0, 2),
                    .cy = matrix.at<double>(1, 2),
                    .k1 = distortion.at<double>(0),
                    .k2 = distortion.at<double>(1)};
  return is_lens(lens) ? std::optional(lens) : std::nullopt;
}

}  // namespace stof::host
