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
  double sigma = 0;  // of q, relative to the other looks
};

struct SeenPlane {
  Eigen::Vector3d m;
  // From how far the looks lie off the plane.
  Eigen::Matrix3d covariance;
  // By how much m changes when every look is 1 m farther off along its ray than it was read: of
  // range cameras, whose readings share an offset. Zero for others.
  Eigen::Vector3d per_offset;
  double share = 0;   // of the looks that lie on the plane
  double misfit = 0;  // rms of those, in `sigma`
};

inline constexpr std::size_t kFewestLooks = 30;

// The plane that most looks lie on, others left out: what stands before a wall or beside it. None
// where there are fewer than kFewestLooks, or less than half of them lie on one plane. `ranges`:
// the looks are of a range camera.
std::optional<SeenPlane> plane_of(const std::vector<PlaneLook>& looks, bool ranges);

}  // namespace stof::host
