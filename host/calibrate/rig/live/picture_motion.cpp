#include "host/calibrate/rig/live/picture_motion.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace stof::host {
namespace {

constexpr int kMostFeatures = 60;
constexpr double kFeatureQuality = 0.02;
constexpr double kFeatureDistance = 20;  // px
constexpr int kHalfPatch = 9;
constexpr int kReach = 12;
constexpr double kLeastScore = 0.8;
constexpr std::size_t kFewest = 12;

// Borrowed: OpenCV's pictures are not read-only, and these functions only read.
cv::Mat as_mat(const dataset::Image<std::uint8_t>& picture) {
  return {picture.height, picture.width, CV_8UC1, const_cast<std::uint8_t*>(picture.pixels.data())};
}

// Of the best score in whole pixels, moved to the top of the parabola through it and its
// neighbours.
double top_of(double before, double best, double after) {
  const double bend = before - 2 * best + after;
  return bend < 0 ? std::clamp((before - after) / (2 * bend), -0.5, 0.5) : 0;
}

std::optional<double> moved(const cv::Mat& scores) {
  double best = 0;
  cv::Point at;
  cv::minMaxLoc(scores, nullptr, &best, nullptr, &at);
  if (best < kLeastScore || at.x == 0 || at.y == 0 || at.x + 1 == scores.cols ||
      at.y + 1 == scores.rows) {
    return std::nullopt;
  }
  const auto score = [&](int x, int y) { return static_cast<double>(scores.at<float>(y, x)); };
  const double du = at.x + top_of(score(at.x - 1, at.y), best, score(at.x + 1, at.y)) - kReach;
  const double dv = at.y + top_of(score(at.x, at.y - 1), best, score(at.x, at.y + 1)) - kReach;
  return std::hypot(du, dv);
}

}  // namespace

std::optional<double> picture_motion(const dataset::Image<std::uint8_t>& before,
                                     const dataset::Image<std::uint8_t>& now) {
  if (before.width != now.width || before.height != now.height) {
    return std::nullopt;
  }
  const cv::Mat from = as_mat(before);
  const cv::Mat to = as_mat(now);
  std::vector<cv::Point2f> features;
  cv::goodFeaturesToTrack(from, features, kMostFeatures, kFeatureQuality, kFeatureDistance);
  std::vector<double> distances;
  const cv::Rect whole(0, 0, before.width, before.height);
  constexpr int kSide = 2 * kHalfPatch + 1;
  for (const cv::Point2f& feature : features) {
    const cv::Rect patch(static_cast<int>(std::lround(feature.x)) - kHalfPatch,
                         static_cast<int>(std::lround(feature.y)) - kHalfPatch, kSide, kSide);
    const cv::Rect search(patch.x - kReach, patch.y - kReach, kSide + 2 * kReach,
                          kSide + 2 * kReach);
    if ((search & whole) != search) {
      continue;
    }
    cv::Mat scores;
    cv::matchTemplate(to(search), from(patch), scores, cv::TM_CCOEFF_NORMED);
    if (const std::optional<double> distance = moved(scores)) {
      distances.push_back(*distance);
    }
  }
  if (distances.size() < kFewest) {
    return std::nullopt;
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle;
}

}  // namespace stof::host
