#include "host/calibrate/rig/check/rig_check.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "dataset/files/file.h"
#include "dsp/stereo/rectify/rectifier.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/evaluate/workspace.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kMostFeatures = 300;
constexpr double kFeatureQuality = 0.02;
constexpr double kFeatureDistance = 12;  // px
constexpr int kHalfPatch = 9;
constexpr int kRows = 12;  // looked at above and below
constexpr double kLeastScore = 0.85;
constexpr std::size_t kFewestPoints = 20;
constexpr double kOutlierSigmas = 4;
constexpr double kSigmaOfMad = 1.4826;
constexpr double kLeastSpreadPx = 0.05;
constexpr double kAtM = 2;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

double deviation(const std::vector<double>& values, double from) {
  std::vector<double> off;
  off.reserve(values.size());
  for (const double value : values) {
    off.push_back(std::abs(value - from));
  }
  return kSigmaOfMad * median(std::move(off));
}

// Borrowed: OpenCV's pictures are not read-only, and these functions only read.
cv::Mat borrowed(const dataset::Image<std::uint8_t>& picture) {
  return {picture.height, picture.width, CV_8UC1, const_cast<std::uint8_t*>(picture.pixels.data())};
}

std::optional<double> row_of(const cv::Mat& scores, const cv::Point& best) {
  if (best.y == 0 || best.y + 1 >= scores.rows) {
    return std::nullopt;
  }
  const auto at = [&](int y) { return static_cast<double>(scores.at<float>(y, best.x)); };
  const double bend = at(best.y - 1) - 2 * at(best.y) + at(best.y + 1);
  const double shift = bend < 0 ? (at(best.y - 1) - at(best.y + 1)) / (2 * bend) : 0;
  return best.y + std::clamp(shift, -0.5, 0.5);
}

struct RectifiedPair {
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
};

// The pictures as they are matched.
class Rectifying {
 public:
  explicit Rectifying(const dsp::StereoRig& rig) {
    if (rig.raw) {
      space_.emplace(dsp::bytes_taken([&](dsp::Arena& arena) { dsp::Rectifier(rig, arena); }));
      dsp::Arena arena = space_->arena();
      rectifier_.emplace(rig, arena);
    }
  }
  RectifiedPair operator()(const Pair& pair) {
    RectifiedPair made{pair.left, pair.right};
    if (rectifier_) {
      rectifier_->rectify(pair.left.view(), pair.right.view(), made.left.view().rows());
      copy(rectifier_->left(), made.left);
      copy(rectifier_->right(), made.right);
    }
    return made;
  }

 private:
  static void copy(dsp::ImageView<const std::uint8_t> from, dataset::Image<std::uint8_t>& to) {
    for (int y = 0; y < from.height(); ++y) {
      std::ranges::copy(from.row(y), to.view().row(y).begin());
    }
  }
  std::optional<Workspace> space_;
  std::optional<dsp::Rectifier> rectifier_;
};

// How far each PMD reading is off what the pair sees there, mm at 2 m; `turn` is the PMD camera's,
// one reading of `every` is looked at.
std::vector<double> readings_off(const std::vector<BothLooks>& looks,
                                 const dsp::Calibration& calibration, const Matrix3& turn,
                                 std::size_t every) {
  const Vector3 shift = translation_of(pose_of(calibration.pmd_to_stereo));
  std::vector<double> off;
  // Rays nearer than this see the same place, but for edges, which the median leaves out.
  const double near = 8 / calibration.stereo.left.fx;
  for (const BothLooks& both : looks) {
    for (std::size_t n = 0; n < both.pmd.size(); n += every) {
      const PlaneLook& pmd = both.pmd[n];
      const Vector3 point = turn * (pmd.ray / pmd.q) + shift;
      if (!(point.z() > 0)) {
        continue;
      }
      for (const PlaneLook& stereo : both.stereo) {
        if (std::abs(stereo.ray.x() - point.x() / point.z()) < near &&
            std::abs(stereo.ray.y() - point.y() / point.z()) < near) {
          off.push_back((stereo.q - 1 / point.z()) * kAtM * kAtM * kMm);
          break;
        }
      }
    }
  }
  return off;
}

// DepthCheck::turn_shows_deg of one axis, by turning the camera in the computer.
double shows_from(const std::vector<BothLooks>& looks, const dsp::Calibration& calibration,
                  int axis) {
  constexpr std::array kTurnsDeg{0.25, 0.5, 0.75,           1.0, 1.5, 2.0, 3.0, 4.0,
                                 6.0,  8.0, kLargestTurnDeg};
  constexpr std::size_t kEnoughReadings = 600;
  std::size_t readings = 0;
  for (const BothLooks& both : looks) {
    readings += both.pmd.size();
  }
  const std::size_t every = readings / kEnoughReadings + 1;
  const Matrix3 turn = rotation_of(pose_of(calibration.pmd_to_stereo));
  const auto median_at = [&](double degrees) {
    const Eigen::AngleAxisd more(degrees / kDegrees, Vector3::Unit(axis));
    const std::vector<double> off =
        readings_off(looks, calibration, more.toRotationMatrix() * turn, every);
    return off.size() >= kFewestPoints ? std::optional(median(off)) : std::nullopt;
  };
  const std::optional<double> now = median_at(0);
  if (!now) {
    return DepthCheck::kNever;
  }
  // What disagrees already may hide as much of a turn.
  const double least = kLargestDepthMm + std::min(std::abs(*now), kLargestDepthMm);
  const auto shows = [&](double degrees) {
    const std::optional<double> then = median_at(degrees);
    return then && std::abs(*then - *now) > least;
  };
  for (const double degrees : kTurnsDeg) {
    if (shows(degrees) && shows(-degrees)) {
      return degrees;
    }
  }
  return DepthCheck::kNever;
}

}  // namespace

std::vector<RowPoint> row_points(const dataset::Image<std::uint8_t>& left,
                                 const dataset::Image<std::uint8_t>& right,
                                 const WallPairOptions& options) {
  const cv::Mat from = borrowed(left);
  const cv::Mat to = borrowed(right);
  std::vector<cv::Point2f> features;
  cv::goodFeaturesToTrack(from, features, kMostFeatures, kFeatureQuality, kFeatureDistance);
  std::vector<RowPoint> points;
  const cv::Rect whole(0, 0, left.width, left.height);
  constexpr int kSide = 2 * kHalfPatch + 1;
  for (const cv::Point2f& feature : features) {
    const int x = static_cast<int>(std::lround(feature.x));
    const int y = static_cast<int>(std::lround(feature.y));
    const cv::Rect patch(x - kHalfPatch, y - kHalfPatch, kSide, kSide);
    const int first = std::max(0, patch.x - options.min_disparity - options.disparities);
    const int last = std::min(left.width, patch.x - options.min_disparity + kSide);
    const cv::Rect search(first, patch.y - kRows, last - first, kSide + 2 * kRows);
    if ((patch & whole) != patch || search.width < kSide || (search & whole) != search) {
      continue;
    }
    cv::Mat scores;
    cv::matchTemplate(to(search), from(patch), scores, cv::TM_CCOEFF_NORMED);
    double best = 0;
    cv::Point at;
    cv::minMaxLoc(scores, nullptr, &best, nullptr, &at);
    const std::optional<double> row = best >= kLeastScore ? row_of(scores, at) : std::nullopt;
    if (row) {
      points.push_back({static_cast<double>(x), *row - kRows});
    }
  }
  return points;
}

std::optional<RowCheck> check_rows(const std::vector<RowPoint>& points, int width) {
  if (points.size() < kFewestPoints) {
    return std::nullopt;
  }
  std::vector<double> rows;
  rows.reserve(points.size());
  for (const RowPoint& point : points) {
    rows.push_back(point.dv);
  }
  RowCheck check;
  check.median_px = median(rows);
  const double limit = kOutlierSigmas * std::max(deviation(rows, check.median_px), kLeastSpreadPx);
  double count = 0, sum_u = 0, sum_v = 0, sum_uu = 0, sum_uv = 0, squares = 0;
  for (const RowPoint& point : points) {
    if (std::abs(point.dv - check.median_px) > limit) {
      continue;
    }
    const double u = point.u / width - 0.5;
    count += 1;
    sum_u += u;
    sum_v += point.dv;
    sum_uu += u * u;
    sum_uv += u * point.dv;
    squares += point.dv * point.dv;
  }
  check.points = static_cast<std::size_t>(count);
  check.rms_px = std::sqrt(squares / count);
  const double spread = sum_uu - sum_u * sum_u / count;
  check.slope_px = spread > 0 ? (sum_uv - sum_u * sum_v / count) / spread : 0;
  return check;
}

std::optional<DepthCheck> check_depths(const std::vector<BothLooks>& looks,
                                       const dsp::Calibration& calibration) {
  const Matrix3 turn = rotation_of(pose_of(calibration.pmd_to_stereo));
  const std::vector<double> off = readings_off(looks, calibration, turn, 1);
  if (off.size() < kFewestPoints) {
    return std::nullopt;
  }
  DepthCheck check{.points = off.size(), .median_mm = median(off)};
  check.spread_mm = deviation(off, check.median_mm);
  for (int axis = 0; axis < 3; ++axis) {
    check.turn_shows_deg[static_cast<std::size_t>(axis)] = shows_from(looks, calibration, axis);
  }
  return check;
}

std::vector<std::string> advice(const RigCheck& check) {
  std::vector<std::string> lines;
  if (!check.rows) {
    lines.emplace_back(
        "rows cannot be judged, the eyes share too few points: uncover both cameras, check that "
        "left and right are not exchanged, and show them something with texture");
  } else if (std::abs(check.rows->median_px) > kLargestRowPx ||
             check.rows->rms_px > kLargestRowPx || std::abs(check.rows->slope_px) > kLargestRowPx) {
    lines.push_back(
        printed("rows do not correspond (%.1f px is allowed): calibrate the pair anew "
                "(stof calib stereo --target), then the place of the PMD camera",
                kLargestRowPx));
  } else if (check.depths && std::abs(check.depths->median_mm) > kLargestDepthMm) {
    lines.push_back(
        printed("the sensors disagree (%.0f mm at 2 m is allowed): calibrate the PMD "
                "camera at a wall (stof calib pmd), then its place (stof calib "
                "extrinsics)",
                kLargestDepthMm));
  }
  return lines;
}

std::vector<std::string> doubts(const RigCheck& check) {
  if (!check.depths) {
    return {"nothing here tells where the PMD camera is"};
  }
  const auto from = [&](std::size_t axis) {
    const double degrees = check.depths->turn_shows_deg[axis];
    return std::isfinite(degrees) ? printed("%.2g degrees", degrees)
                                  : printed("more than %.0f degrees", kLargestTurnDeg);
  };
  return {"a PMD camera that is turned shows here from " + from(0) + " up or down, " + from(1) +
          " sideways and " + from(2) +
          " about its axis on (stof calib extrinsics judges its place by walls)"};
}

dataset::Loaded<RigCheck> check_rig(const std::filesystem::path& dir,
                                    const dsp::Calibration& calibration,
                                    const WallPairOptions& options) {
  const dataset::Loaded<std::vector<std::filesystem::path>> pairs = list_pairs(dir);
  if (!pairs) {
    return std::unexpected(pairs.error());
  }
  Rectifying rectify(calibration.stereo);
  std::vector<RowPoint> points;
  bool pmd = calibration.pmd.lens.width > 0;
  for (const std::filesystem::path& folder : *pairs) {
    const dataset::Loaded<Pair> pair = read_pair(folder);
    if (!pair) {
      return std::unexpected(pair.error());
    }
    if (pair->left.width != calibration.stereo.left.width ||
        pair->left.height != calibration.stereo.left.height) {
      return dataset::refuse(folder, "is of another size than the calibration",
                             "give the calibration of this rig");
    }
    const RectifiedPair rectified = rectify(*pair);
    const std::vector<RowPoint> more = row_points(rectified.left, rectified.right, options);
    points.insert(points.end(), more.begin(), more.end());
    pmd = pmd && dataset::is_there(folder / "pmd.json");
  }
  RigCheck check;
  check.rows = check_rows(points, calibration.stereo.left.width);
  if (pmd) {
    const dataset::Loaded<std::vector<BothLooks>> looks = read_looks(dir, calibration, options);
    if (!looks) {
      return std::unexpected(looks.error());
    }
    check.depths = check_depths(*looks, calibration);
  }
  if (!check.rows && !check.depths) {
    return dataset::refuse(dir, "shows too little to judge a rig by",
                           "give pictures of something with texture");
  }
  return check;
}

}  // namespace stof::host
