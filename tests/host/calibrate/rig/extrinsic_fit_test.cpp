#include "host/calibrate/rig/extrinsics/extrinsic_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "dsp/calib/pmd/ray_table.h"
#include "tests/host/calibrate/rig/gaussian.h"

namespace stof::host {
namespace {

using test::Gaussian;

constexpr double kDegree = std::numbers::pi / 180;
// Turned by some degrees, 9 cm beside the left camera.
const PoseUnknowns kTruth{0.03, -0.05, 0.02, 0.09, -0.03, 0.02};

struct PmdKind {
  dsp::Pinhole lens;
  double sigma_m;  // of a reading, after its frames are averaged
};
const PmdKind kChapter{
    {.width = 64, .height = 16, .fx = 45.28, .fy = 45.28, .cx = 32.8, .cy = 10, .k1 = -0.1}, 0.006};
const PmdKind kFine{{.width = 176, .height = 144, .fx = 180, .fy = 180, .cx = 88, .cy = 72}, 0.006};

std::vector<Vector3> rays_of(const dsp::Pinhole& lens) {
  std::vector<Vector3> rays;
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      const std::array<double, 3> r = dsp::unit_ray(lens, u, v);
      rays.emplace_back(r[0], r[1], r[2]);
    }
  }
  return rays;
}

// By how much a PMD camera reads too far: everywhere, and at knots of the distance.
struct TooFar {
  double offset_m = 0;
  std::array<double, kRangeKnots> leftover_m{};

  double at(double d) const {
    const double place = std::clamp(d / kRangeStepM - 1, 0.0, kRangeKnots - 1.001);
    const auto knot = static_cast<std::size_t>(place);
    const double part = place - static_cast<double>(knot);
    return offset_m + (1 - part) * leftover_m[knot] + part * leftover_m[knot + 1];
  }
};

// Both sensors' looks at a plane n . X = distance in the left camera's axes.
SeenWall seen_wall(const PmdKind& kind, const Vector3& normal, double distance,
                   const TooFar& too_far, Gaussian& random) {
  std::vector<PlaneLook> stereo;
  const Vector3 m = normal.normalized() / distance;
  for (double v = 8; v < 480; v += 16) {
    for (double u = 8; u < 640; u += 16) {
      const Vector3 ray((u - 320) / 600, (v - 240) / 600, 1);
      const double q = m.dot(ray);
      // 0.15 px of disparity with a baseline of 12 cm.
      const double sigma = 0.15 / (600 * 0.12);
      if (q > 0.1) {
        stereo.push_back({ray, q + random.next(sigma), sigma});
      }
    }
  }
  std::vector<PlaneLook> pmd;
  const Vector3 turned = rotation_of(kTruth).transpose() * m / (1 - m.dot(translation_of(kTruth)));
  static const std::vector<Vector3> chapter = rays_of(kChapter.lens);
  static const std::vector<Vector3> fine = rays_of(kFine.lens);
  for (const Vector3& ray : &kind == &kChapter ? chapter : fine) {
    const double d = 1 / turned.dot(ray);
    if (d > 0.3 && d < 7) {
      const double read = d + too_far.at(d) + random.next(kind.sigma_m);
      pmd.push_back({ray, 1 / read, kind.sigma_m / (d * d)});
    }
  }
  const std::optional<SeenPlane> a = plane_of(stereo, false);
  const std::optional<SeenPlane> b = plane_of(pmd, true);
  EXPECT_TRUE(a && b);
  return {.name = "", .stereo = a.value_or(SeenPlane{}), .pmd = b.value_or(SeenPlane{})};
}

std::vector<SeenWall> walls(const PmdKind& kind, std::uint64_t seed, const TooFar& too_far = {}) {
  Gaussian random(seed);
  std::vector<SeenWall> seen;
  for (const auto& [sideways, upwards, distance] :
       {std::tuple(0.0, 0.0, 1.5), std::tuple(0.5, 0.0, 1.4), std::tuple(-0.5, 0.0, 1.6),
        std::tuple(0.0, 0.45, 1.5), std::tuple(0.0, -0.45, 1.3), std::tuple(0.35, 0.35, 1.9),
        std::tuple(-0.35, 0.35, 1.2), std::tuple(0.35, -0.35, 1.7)}) {
    seen.push_back(seen_wall(kind, Vector3(std::tan(sideways), std::tan(upwards), 1), distance,
                             too_far, random));
  }
  return seen;
}

struct Consistency {
  double mean = 0;
  int inside = 0;
  double turn = 0;   // largest
  double shift = 0;  // largest
};

Consistency over_seeds(const PmdKind& kind) {
  constexpr int kSeeds = 100;
  constexpr double kEllipsoid95 = 12.592;  // chi^2, 6 degrees of freedom
  Consistency found;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Gaussian random(1000 + seed);
    TooFar too_far{.offset_m = random.next(0.003)};
    std::ranges::generate(too_far.leftover_m, [&] { return random.next(0.001); });
    const std::optional<ExtrinsicFit> fit = fit_extrinsics(
        walls(kind, seed, too_far), {.offset_sigma_m = 0.003, .leftover_sigma_m = 0.001});
    EXPECT_TRUE(fit);
    if (!fit) {
      return found;
    }
    const Eigen::Matrix<double, 6, 1> off = difference(fit->pmd_to_stereo, kTruth);
    const double squared = off.dot(fit->covariance.inverse() * off);
    found.mean += squared / kSeeds;
    found.inside += squared <= kEllipsoid95 ? 1 : 0;
    found.turn = std::max(found.turn, off.head<3>().norm());
    found.shift = std::max(found.shift, off.tail<3>().norm());
  }
  std::printf("figure: %dx%d: mean NEES %.2f, %d of 100 inside, turn %.3f degrees, shift %.1f mm\n",
              kind.lens.width, kind.lens.height, found.mean, found.inside, found.turn / kDegree,
              found.shift * 1000);
  return found;
}

TEST(ExtrinsicFit, TheChaptersSensorIsPlacedAndItsCovarianceIsThatOfTheErrors) {
  const Consistency found = over_seeds(kChapter);
  EXPECT_GT(found.mean, 5.3);
  EXPECT_LT(found.mean, 6.7);
  EXPECT_GE(found.inside, 90);
  EXPECT_LT(found.turn, 0.3 * kDegree);
  EXPECT_LT(found.shift, 0.015);
}

TEST(ExtrinsicFit, AFinerSensorIsPlacedBetter) {
  const Consistency found = over_seeds(kFine);
  EXPECT_GT(found.mean, 5.3);
  EXPECT_LT(found.mean, 6.7);
  EXPECT_GE(found.inside, 90);
  EXPECT_LT(found.turn, 0.1 * kDegree);
  EXPECT_LT(found.shift, 0.005);
}

TEST(ExtrinsicFit, TellsHowMuchTooFarThePmdCameraReads) {
  const std::optional<ExtrinsicFit> fit =
      fit_extrinsics(walls(kFine, 3, {.offset_m = 0.01}), {.offset_sigma_m = 0.05});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->offset_m, 0.01, 0.002);
  EXPECT_LT(fit->offset_sigma_m, 0.002);
}

TEST(ExtrinsicFit, NamesTheTiltThatIsMissing) {
  Gaussian random(4);
  std::vector<SeenWall> flat;
  for (const double sideways : {-0.5, -0.2, 0.0, 0.2, 0.5}) {
    flat.push_back(seen_wall(kFine, Vector3(std::tan(sideways), 0, 1), 1.5, {}, random));
  }
  const std::vector<std::string> missing = missing_tilts(flat);
  ASSERT_EQ(missing.size(), 1U);
  EXPECT_NE(missing[0].find("up and down"), std::string::npos);
  EXPECT_FALSE(fit_extrinsics(flat, {})) << "T along rows of the picture is not told";
  EXPECT_TRUE(missing_tilts(walls(kFine, 1)).empty());
}

TEST(WallPlane, LeavesOutWhatStandsBeforeTheWall) {
  Gaussian random(9);
  std::vector<PlaneLook> looks;
  const Vector3 m(0.1, -0.05, 0.5);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 ray(random.between(-0.5, 0.5), random.between(-0.4, 0.4), 1);
    const bool before = i % 3 == 0;
    looks.push_back({ray, (before ? 0.9 : m.dot(ray)) + random.next(0.002), 0.002});
  }
  const std::optional<SeenPlane> plane = plane_of(looks, false);
  ASSERT_TRUE(plane);
  EXPECT_LT((plane->m - m).norm(), 0.002);
  EXPECT_NEAR(plane->share, 2.0 / 3, 0.02);
}

}  // namespace
}  // namespace stof::host
