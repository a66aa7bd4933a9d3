#include "host/calibrate/rig/target/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "host/text/printed.h"

namespace stof::host {
namespace {

// Of the convex hull of the corners that are seen.
double area_of(const std::vector<PixelPoint>& corners) {
  std::vector<cv::Point2f> seen;
  for (const PixelPoint& corner : corners) {
    if (corner.seen()) {
      seen.emplace_back(static_cast<float>(corner.u), static_cast<float>(corner.v));
    }
  }
  if (seen.empty()) {
    return 0;
  }
  std::vector<cv::Point2f> hull;
  cv::convexHull(seen, hull);
  return cv::contourArea(hull);
}

struct PictureCorner {
  const char* name;
  bool right;
  bool low;
};
constexpr std::array<PictureCorner, 4> kPictureCorners{{{"upper left", false, false},
                                                        {"upper right", true, false},
                                                        {"lower left", false, true},
                                                        {"lower right", true, true}}};

bool reaches(const std::vector<PixelPoint>& corners, const PictureCorner& which, int width,
             int height) {
  return std::ranges::any_of(corners, [&](const PixelPoint& p) {
    const double x = which.right ? width - 1 - p.u : p.u;
    const double y = which.low ? height - 1 - p.v : p.v;
    return x < kCornerShare * width && y < kCornerShare * height;
  });
}

void add_corners(const std::vector<PairView>& views, int width, int height,
                 std::vector<std::string>& missing) {
  for (const auto& [name, eye] :
       {std::pair("left", &PairView::left), std::pair("right", &PairView::right)}) {
    std::string absent;
    for (const PictureCorner& which : kPictureCorners) {
      if (std::ranges::none_of(views, [&](const PairView& view) {
            return reaches(view.*eye, which, width, height);
          })) {
        add_to(absent, which.name, ", ");
      }
    }
    if (!absent.empty()) {
      missing.push_back(std::string("corners: no view reaches the ") + absent + " of the " + name +
                        " picture (a view that this eye alone sees whole serves too)");
    }
  }
}

}  // namespace

unsigned reached_corners(const std::vector<PairView>& views, int width, int height) {
  unsigned reached = 0;
  unsigned bit = 1;
  for (std::vector<PixelPoint> PairView::* const eye : {&PairView::left, &PairView::right}) {
    for (const PictureCorner& which : kPictureCorners) {
      const bool found = std::ranges::any_of(
          views, [&](const PairView& view) { return reaches(view.*eye, which, width, height); });
      reached |= found ? bit : 0U;
      bit <<= 1U;
    }
  }
  return reached;
}

ViewPose view_pose(const Board& board, const PairView& view, const PoseUnknowns& pose,
                   const dsp::RawPair& rig) {
  const Matrix3 turn = rotation_of(pose);
  const std::array<double, 2> last = board.at(board.corners() - 1);
  const Vector3 middle = turn * Vector3(last[0] / 2, last[1] / 2, 0) + translation_of(pose);
  // Against the direction in which the board is seen, so that one held up facing the camera counts
  // as not tilted wherever it is in the picture.
  const Matrix3 facing =
      Eigen::Quaterniond::FromTwoVectors(middle, Vector3::UnitZ()).toRotationMatrix();
  const Vector3 normal = facing * turn.col(2);
  const double picture = static_cast<double>(rig.left.width) * rig.left.height;
  return {.distance_m = middle.norm(),
          .share = std::max(area_of(view.left), area_of(view.right)) / picture,
          .sideways_rad = std::atan2(-normal.x(), normal.z()),
          .upwards_rad = std::atan2(-normal.y(), normal.z())};
}

std::vector<std::string> missing_views(const std::vector<PairView>& views,
                                       const std::vector<ViewPose>& poses, int width, int height) {
  std::vector<std::string> missing;
  const auto both = static_cast<std::size_t>(std::ranges::count_if(views, &PairView::both));
  if (both < kFewestBothViews) {
    missing.push_back(printed("more: %zu views show the whole board to both eyes, %zu are needed",
                              both, kFewestBothViews));
  }
  double largest = 0;
  double smallest = 1;
  int sideways = 0;
  int upwards = 0;
  for (const ViewPose& pose : poses) {
    largest = std::max(largest, pose.share);
    smallest = std::min(smallest, pose.share);
    sideways += std::abs(pose.sideways_rad) >= kLeastTiltRad ? 1 : 0;
    upwards += std::abs(pose.upwards_rad) >= kLeastTiltRad ? 1 : 0;
  }
  if (largest < kNearShare) {
    missing.push_back(
        printed("near: the board never fills more than %.0f percent of a picture, "
                "%.0f are needed",
                largest * kPercent, kNearShare * kPercent));
  }
  if (std::sqrt(smallest) > kFarRatio * std::sqrt(largest)) {
    missing.emplace_back(
        "far: all views have about the same distance; take some from twice as far");
  }
  if (sideways < kLeastTilted) {
    missing.push_back(
        printed("tilted: %d views are turned sideways by 15 degrees or more, %d are "
                "needed",
                sideways, kLeastTilted));
  }
  if (upwards < kLeastTilted) {
    missing.push_back(
        printed("tilted: %d views are tilted up or down by 15 degrees or more, %d "
                "are needed",
                upwards, kLeastTilted));
  }
  add_corners(views, width, height, missing);
  return missing;
}

}  // namespace stof::host
