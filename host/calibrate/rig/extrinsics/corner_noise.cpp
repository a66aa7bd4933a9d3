#include "host/calibrate/rig/extrinsics/corner_noise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace stof::host {
namespace {

constexpr int kSteps = 30;
constexpr double kMostSigmas = 3;
constexpr double kLeastVariance = 1e-8;  // px^2
constexpr double kSame = 1e-6;           // of both components

// Along one of the axes of a corner's covariance.
struct Part {
  double variance = 0;  // as found, px^2
  double square = 0;    // of what it is off, px^2
};

void add_parts(const CornerOff& corner, std::vector<Part>& parts) {
  const PixelPoint& c = corner.found;
  const double middle = (c.uu + c.vv) / 2;
  const double half = std::hypot((c.uu - c.vv) / 2, c.uv);
  const double angle = std::atan2(2 * c.uv, c.uu - c.vv) / 2;
  const double along = std::cos(angle) * corner.u + std::sin(angle) * corner.v;
  const double across = std::cos(angle) * corner.v - std::sin(angle) * corner.u;
  parts.push_back({middle + half, along * along});
  parts.push_back({std::max(0.0, middle - half), across * across});
}

// One step of Fisher's scoring: least squares of the squares on both components, each by the
// variance that it has so far. A component that came out negative is none.
CornerNoise scored(const std::vector<Part>& parts, double freedom, const CornerNoise& noise) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Part& part : parts) {
    const double variance = std::max(kLeastVariance, noise.scale * part.variance + noise.floor);
    const double square = std::min(part.square / freedom, kMostSigmas * kMostSigmas * variance);
    const Eigen::Vector2d row(part.variance, 1);
    normal += row * row.transpose() / (variance * variance);
    right += row * square / (variance * variance);
  }
  // Where all corners are alike both components are one: then it is the first.
  const double scale_alone = right(0) / normal(0, 0);
  const double floor_alone = right(1) / normal(1, 1);
  const double apart = 1 - normal(0, 1) * normal(0, 1) / (normal(0, 0) * normal(1, 1));
  if (!(apart > 1e-9)) {
    return {.scale = scale_alone, .floor = 0};
  }
  const Eigen::Vector2d both = normal.ldlt().solve(right);
  if (both(1) < 0) {
    return {.scale = scale_alone, .floor = 0};
  }
  return both(0) < 0 ? CornerNoise{.scale = 0, .floor = floor_alone}
                     : CornerNoise{.scale = both(0), .floor = both(1)};
}

}  // namespace

CornerNoise corner_noise(const std::vector<CornerOff>& corners, double freedom,
                         const CornerNoise& start) {
  std::vector<Part> parts;
  for (const CornerOff& corner : corners) {
    add_parts(corner, parts);
  }
  CornerNoise noise = start;
  for (int step = 0; step < kSteps && !parts.empty(); ++step) {
    const CornerNoise next = scored(parts, freedom, noise);
    const bool same = std::abs(next.scale - noise.scale) <= kSame * next.scale &&
                      std::abs(next.floor - noise.floor) <= kSame * next.floor;
    noise = next;
    if (same) {
      break;
    }
  }
  noise.floor = std::max(noise.floor, kLeastVariance);
  return noise;
}

}  // namespace stof::host
