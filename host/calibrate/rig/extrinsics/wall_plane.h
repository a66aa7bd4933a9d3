#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace stof::host {

// One sensor's look at a plane m . X = 1 (m is the unit normal over the distance): X = ray / q, so
// m . ray = q, which is linear. Of a range camera: the unit ray and 1 / distance; of a pair: the
// ray with z = 1 and 1 / Z.
struct PlaneLook {
  Eigen::Vector3d ray;
  double q = 0;
  double sigma = 0;         // of q, relative to the other looks; of a pair: a pixel of disparity
  double disparity_px = 0;  // of a pair; 0: not told
};

// What a range camera reads too far by its distance alone, at knots kRangeStepM apart, the first of
// them at kRangeStepM; straight lines between, as the outermost beyond.
inline constexpr int kRangeKnots = 32;
inline constexpr double kRangeStepM = 0.25;
using PerKnot = Eigen::Matrix<double, 3, kRangeKnots>;

struct SeenPlane {
  Eigen::Vector3d m;
  // From how far the looks lie off the plane; of a pair, too, from what looks of like disparities
  // share (kSharedPx).
  Eigen::Matrix3d covariance;
  // By how much m changes when the camera reads 1 m too far at one of the knots. Zero for others
  // than range cameras.
  PerKnot per_knot;
  double share = 0;   // of the looks that lie on the plane
  double misfit = 0;  // rms of those, in `sigma`
};

inline constexpr std::size_t kFewestLooks = 30;
// Standard deviation of what disparities within half a pixel are all off by, once SubpixelLock is
// undone: fitted on 40 rendered rigs, preset `quality`.
inline constexpr double kSharedPx = 0.03;

// The plane that most looks lie on, others left out: what stands before a wall or beside it. None
// where there are fewer than kFewestLooks, or less than half of them lie on one plane. `ranges`:
// the looks are of a range camera.
std::optional<SeenPlane> plane_of(const std::vector<PlaneLook>& looks, bool ranges);

}  // namespace stof::host
