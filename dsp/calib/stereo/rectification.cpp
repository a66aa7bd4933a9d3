#include "dsp/calib/stereo/rectification.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "dsp/calib/pmd/ray_table.h"

namespace stof::dsp {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vector = Eigen::Vector3d;

constexpr double kLargestTurnRad = 1.05;      // 60 degrees
constexpr double kLeastAlongBaseline = 0.71;  // 45 degrees
constexpr double kShortestBaselineM = 1e-3;
constexpr double kLongestBaselineM = 100;
constexpr double kLargestShift = 1.0 / 8;  // of the width
constexpr int kProbes = 24;                // rows and columns of pixels that are looked at
constexpr double kLeastInside = 0.25;      // of them
constexpr double kNever = std::numeric_limits<double>::infinity();

Matrix matrix_of(const std::array<double, 9>& elements) noexcept {
  return Eigen::Map<const Matrix>(elements.data());
}

std::array<double, 9> elements_of(const Matrix& matrix) noexcept {
  std::array<double, 9> elements{};
  Eigen::Map<Matrix>(elements.data()) = matrix;
  return elements;
}

Vector translation(const RawPair& pair) noexcept {
  return Eigen::Map<const Vector>(pair.left_to_right.translation_m.data());
}

// The rotation, exactly orthonormal.
Eigen::AngleAxisd turn_of(const RawPair& pair) noexcept {
  const Eigen::Quaterniond nearest(matrix_of(pair.left_to_right.rotation));
  return Eigen::AngleAxisd(nearest.normalized());
}

// Both cameras as they stand when each has turned half way towards the other.
struct Halves {
  Matrix left;
  Matrix right;
  Vector baseline;  // from the left to the right camera, in their common axes
};

Halves halves_of(const RawPair& pair) noexcept {
  const Eigen::AngleAxisd turn = turn_of(pair);
  const Eigen::AngleAxisd half(turn.angle() / 2, turn.axis());
  Halves halves;
  halves.left = half.toRotationMatrix();
  halves.right = halves.left.transpose();
  halves.baseline = -(halves.right * translation(pair));
  return halves;
}

// Where the middle of the raw picture would lie with focal length 1 and centre (0, 0).
Vector middle_of(const Pinhole& raw, const Matrix& turn) noexcept {
  const std::array<double, 3> ray = unit_ray(raw, (raw.width - 1) / 2.0, (raw.height - 1) / 2.0);
  const Vector turned = turn * Eigen::Map<const Vector>(ray.data());
  return turned / turned.z();
}

bool shows_enough(const SourceMap& map) noexcept {
  const Pinhole& picture = map.rectified();
  int inside = 0;
  for (int j = 0; j < kProbes; ++j) {
    for (int i = 0; i < kProbes; ++i) {
      const double u = (picture.width - 1) * (i + 0.5) / kProbes;
      const double v = (picture.height - 1) * (j + 0.5) / kProbes;
      inside += map.at(u, v).inside ? 1 : 0;
    }
  }
  return inside >= kLeastInside * kProbes * kProbes;
}

bool radial_to_fourth(const Pinhole& lens) noexcept {
  return lens.k3 == 0 && lens.p1 == 0 && lens.p2 == 0;
}

// The smallest positive root of 1 + 3 k1 s + 5 k2 s^2, the derivative of r (1 + k1 r^2 + k2 r^4)
// with s = r^2: from there on a larger angle does not lie further out.
double fold_of_two(const Pinhole& lens) noexcept {
  const double a = 5 * lens.k2;
  const double b = 3 * lens.k1;
  const double discriminant = b * b - 4 * a;
  if (discriminant < 0) {
    return kNever;
  }
  const double q = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
  double smallest = kNever;
  for (const double root : {q / a, 1 / q}) {  // an absent root is infinite or not a number
    smallest = root > 0 ? std::min(smallest, root) : smallest;
  }
  return smallest;
}

// The same with 7 k3 s^3, to 1e-12 of it: steps out to kWidest, then halves.
double fold_of(const Pinhole& lens) noexcept {
  if (lens.k3 == 0) {
    return fold_of_two(lens);
  }
  constexpr double kWidest = 9;  // 72 degrees from the axis
  constexpr int kSteps = 4096;
  constexpr int kHalves = 40;
  const auto falls = [&lens](double s) noexcept {
    return !(1 + s * (3 * lens.k1 + s * (5 * lens.k2 + s * 7 * lens.k3)) > 0);
  };
  for (int i = 1; i <= kSteps; ++i) {
    double high = kWidest * i / kSteps;
    if (falls(high)) {
      double low = kWidest * (i - 1) / kSteps;
      for (int k = 0; k < kHalves; ++k) {
        const double middle = (low + high) / 2;
        (falls(middle) ? high : low) = middle;
      }
      return low;
    }
  }
  return kWidest;  // no picture reaches further
}

// Pinhole's distortion of a place on the normalised plane, and the determinant of its derivative:
// 0 or less where two directions show up at one place.
struct BentPoint {
  double x = 0;
  double y = 0;
  double determinant = 0;
};

BentPoint bend(const Pinhole& lens, double x, double y) noexcept {
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double slope = lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3);  // of radial with r2
  const double across = 2 * (x * y * slope + lens.p1 * x + lens.p2 * y);
  const double along_x = radial + 2 * x * x * slope + 2 * lens.p1 * y + 6 * lens.p2 * x;
  const double along_y = radial + 2 * y * y * slope + 6 * lens.p1 * y + 2 * lens.p2 * x;
  return {.x = x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
          .y = y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y,
          .determinant = along_x * along_y - across * across};
}

}  // namespace

Rectification rectify(const RawPair& pair) noexcept {
  const Halves halves = halves_of(pair);
  const Matrix along =
      Eigen::Quaterniond::FromTwoVectors(halves.baseline, Vector::UnitX()).toRotationMatrix();
  const Matrix left_turn = along * halves.left;
  const Matrix right_turn = along * halves.right;
  const double focal = (pair.left.fx + pair.left.fy + pair.right.fx + pair.right.fy) / 4;
  const Vector left_middle = focal * middle_of(pair.left, left_turn);
  const Vector right_middle = focal * middle_of(pair.right, right_turn);
  const int width = pair.left.width;
  const int height = pair.left.height;
  // How far either picture is moved when infinity is put at disparity 0; not further than that.
  const double half_gap = (left_middle.x() - right_middle.x()) / 2;
  const double limit = width * kLargestShift;
  const double rest = half_gap - std::clamp(half_gap, -limit, limit);
  const double column = (width - 1) / 2.0 - (left_middle.x() + right_middle.x()) / 2;
  const double row = (height - 1) / 2.0 - (left_middle.y() + right_middle.y()) / 2;

  Rectification result;
  result.left_turn = elements_of(left_turn);
  result.right_turn = elements_of(right_turn);
  result.left = {
      .width = width, .height = height, .fx = focal, .fy = focal, .cx = column - rest, .cy = row};
  result.right = result.left;
  result.right.cx = column + rest;
  result.baseline_m = halves.baseline.norm();
  return result;
}

const char* problem_of(const RawPair& pair) noexcept {
  if (pair.left.width < 2 || pair.left.height < 2 || pair.left.width != pair.right.width ||
      pair.left.height != pair.right.height) {
    return "the raw pictures of left and right differ in size, or are smaller than 2x2";
  }
  if (!(std::abs(turn_of(pair).angle()) <= kLargestTurnRad)) {
    return "the cameras are turned against each other by more than 60 degrees";
  }
  const Vector baseline = halves_of(pair).baseline;
  const double length = baseline.norm();
  if (!(length >= kShortestBaselineM) || !(length <= kLongestBaselineM)) {
    return "the cameras are nearer to each other than 1 mm, or further away than 100 m";
  }
  if (!(baseline.x() >= kLeastAlongBaseline * length)) {
    return "the right camera does not stand to the right of the left one";
  }
  const Rectification rectified = rectify(pair);
  if (!shows_enough(SourceMap(pair.left, rectified.left_turn, rectified.left)) ||
      !shows_enough(SourceMap(pair.right, rectified.right_turn, rectified.right))) {
    return "less than a quarter of a rectified picture shows something: the lenses or the rotation "
           "between them cannot be true";
  }
  return "";
}

SourceMap::SourceMap(const Pinhole& raw, const std::array<double, 9>& turn,
                     const Pinhole& rectified) noexcept
    : raw_(raw), rectified_(rectified), turn_(turn), fold_(fold_of(raw)) {}

SourceMap::Place SourceMap::unbounded(double u, double v) const noexcept {
  const double x = (u - rectified_.cx) / rectified_.fx;
  const double y = (v - rectified_.cy) / rectified_.fy;
  // The transposed turn carries back into the camera's axes.
  const double along_x = turn_[0] * x + turn_[3] * y + turn_[6];
  const double along_y = turn_[1] * x + turn_[4] * y + turn_[7];
  const double forward = turn_[2] * x + turn_[5] * y + turn_[8];
  const double ahead = std::max(forward, 1e-3);
  const double raw_x = along_x / ahead;
  const double raw_y = along_y / ahead;
  const double r2 = raw_x * raw_x + raw_y * raw_y;
  const double s = std::min(r2, fold_);
  if (!radial_to_fourth(raw_)) {
    const double back = s < r2 ? std::sqrt(s / r2) : 1.0;
    const BentPoint bent = bend(raw_, raw_x * back, raw_y * back);
    return {.u = raw_.fx * bent.x + raw_.cx,
            .v = raw_.fy * bent.y + raw_.cy,
            .inside = forward >= ahead && s == r2 && bent.determinant > 0};
  }
  const double stretch = (1 + s * (raw_.k1 + s * raw_.k2)) * (s < r2 ? std::sqrt(s / r2) : 1.0);
  return {.u = raw_.fx * raw_x * stretch + raw_.cx,
          .v = raw_.fy * raw_y * stretch + raw_.cy,
          .inside = forward >= ahead && s == r2};
}

SourceMap::Place SourceMap::at(double u, double v) const noexcept {
  const Place free = unbounded(u, v);
  Place place;
  place.u = std::clamp(free.u, 0.0, raw_.width - 1.0);
  place.v = std::clamp(free.v, 0.0, raw_.height - 1.0);
  place.inside = free.inside && place.u == free.u && place.v == free.v;
  return place;
}

}  // namespace stof::dsp
