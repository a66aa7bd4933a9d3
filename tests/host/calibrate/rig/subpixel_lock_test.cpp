#include "host/calibrate/rig/extrinsics/subpixel_lock.h"

#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/host/calibrate/rig/gaussian.h"

namespace stof::host {
namespace {

using test::Gaussian;

constexpr double kFocalPx = 600;
constexpr double kPerPx = 1 / (kFocalPx * 0.12);  // of 1 / Z

// Towards whole pixels by up to 0.1.
double pulled(double disparity) {
  return disparity - 0.1 * std::sin(2 * std::numbers::pi * disparity);
}

std::vector<PlaneLook> looks_at(const Eigen::Vector3d& m, Gaussian& random) {
  std::vector<PlaneLook> looks;
  for (double v = 6; v < 480; v += 12) {
    for (double u = 6; u < 640; u += 12) {
      const Eigen::Vector3d ray((u - 320) / kFocalPx, (v - 240) / kFocalPx, 1);
      const double found = pulled(m.dot(ray) / kPerPx) + random.next(0.05);
      const double px = std::round(found * 16) / 16;
      looks.push_back({.ray = ray, .q = px * kPerPx, .sigma = kPerPx, .disparity_px = px});
    }
  }
  return looks;
}

double turned_deg(const SeenPlane& plane, const Eigen::Vector3d& m) {
  return std::atan2(plane.m.cross(m).norm(), plane.m.dot(m)) * 180 / std::numbers::pi;
}

TEST(SubpixelLock, IsToldByTiltedWallsAndUndoneOnOneThatFacesThePair) {
  Gaussian random(5);
  SubpixelLock lock;
  for (const Eigen::Vector3d& tilted :
       {Eigen::Vector3d(0.3, 0.1, 0.6), Eigen::Vector3d(-0.2, 0.25, 0.7),
        Eigen::Vector3d(0.1, -0.35, 0.5), Eigen::Vector3d(-0.3, -0.2, 0.8)}) {
    const std::vector<PlaneLook> looks = looks_at(tilted, random);
    const std::optional<SeenPlane> plane = plane_of(looks, false);
    ASSERT_TRUE(plane);
    lock.add(looks, *plane);
  }
  // 0.4 px of disparity from edge to edge.
  const Eigen::Vector3d facing(0.005, -0.002, 0.5535);
  const std::vector<PlaneLook> looks = looks_at(facing, random);
  const std::optional<SeenPlane> bent = plane_of(looks, false);
  const std::optional<SeenPlane> straight = plane_of(lock.undone(looks), false);
  ASSERT_TRUE(bent && straight);
  std::printf("figure: a wall that faces the pair: turned by %.3f degrees, undone %.3f\n",
              turned_deg(*bent, facing), turned_deg(*straight, facing));
  EXPECT_GT(turned_deg(*bent, facing), 0.15);
  EXPECT_LT(turned_deg(*straight, facing), 0.06);
  const Eigen::Vector3d off = straight->m - facing;
  EXPECT_LT(off.dot(straight->covariance.ldlt().solve(off)), 11.3);  // 99 percent of chi^2(3)
}

TEST(SubpixelLock, AWallThatFacesThePairTellsNothing) {
  Gaussian random(6);
  const std::vector<PlaneLook> looks = looks_at({0.005, -0.002, 0.5535}, random);
  const std::optional<SeenPlane> plane = plane_of(looks, false);
  ASSERT_TRUE(plane);
  SubpixelLock lock;
  lock.add(looks, *plane);
  const std::vector<PlaneLook> same = lock.undone(looks);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    ASSERT_EQ(same[i].q, looks[i].q);
  }
}

}  // namespace
}  // namespace stof::host
