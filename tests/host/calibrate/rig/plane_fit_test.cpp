#include "host/calibrate/rig/planes/plane_fit.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "dsp/calib/stereo/column_tables.h"
#include "tests/host/calibrate/rig/gaussian.h"

namespace stof::host {
namespace {

using test::Gaussian;

// The chapter's rig with axes that meet at 4 m.
const PlaneUnknowns kTruth{0.2007, 0.0247, -0.0254, 0.008544, 0.008521};
constexpr PlaneSensor kSensor{.pixel_m = 5.6e-6, .cx_left = 319.5, .cx_right = 319.5, .cy = 239.5};

std::vector<Plane> walls(const PlaneUnknowns& rig, double noise_px, double tape_m, double tilt_rad,
                         std::uint64_t seed) {
  Gaussian random(seed);
  std::vector<Plane> planes;
  for (int n = 0; n < 9; ++n) {
    Plane plane{.name = "", .z_m = 1.6 + 0.3 * n, .disparity = {}, .cells = {}};
    const double offset = random.next(tape_m);
    const double sideways = random.next(tilt_rad);
    const double upwards = random.next(tilt_rad);
    for (double row = 110; row < 370; row += 24) {
      for (double left = 140; left < 500; left += 24) {
        const double ray = (left - kSensor.cx_left) * kSensor.pixel_m / rig[4];
        const double tangent = std::tan(rig[2] - std::atan(ray));
        const double y = (row - kSensor.cy) * kSensor.pixel_m / rig[4];
        const double z = (plane.z_m + offset) / (1 + sideways * tangent - upwards * y);
        const double right = kSensor.cx_right - std::tan(std::atan(rig[0] / z + tangent) - rig[1]) *
                                                    rig[3] / kSensor.pixel_m;
        plane.cells.push_back({left, right + random.next(noise_px), row});
      }
    }
    planes.push_back(std::move(plane));
  }
  return planes;
}

// What matching errors share: drawn to whole and half pixels, on some walls more than on others,
// and disparities that look curved along columns.
void pull(std::vector<Plane>& planes, const PlaneSensor& sensor, Gaussian& random) {
  const double all = random.between(0.03, 0.07);
  const double bent = random.next(0.015);
  for (Plane& plane : planes) {
    const double amplitude = all + random.next(0.01);
    const double curve = bent + random.next(0.005);
    for (PlaneCell& cell : plane.cells) {
      const double column = (cell.left - sensor.cx_left) / (0.6 * sensor.cx_left);
      cell.right -= amplitude * std::sin(2 * std::numbers::pi * (cell.left - cell.right)) +
                    curve * column * column;
    }
  }
}

// What is told of the rig, as wrong as it is told to be.
PlanePriors told(Gaussian& random) {
  PlanePriors priors;
  priors.baseline_m = kTruth[0] + random.next(priors.baseline_sigma_m);
  priors.focal_m = (kTruth[3] + kTruth[4]) / 2 * (1 + random.next(priors.focal_sigma));
  return priors;
}

// Small pictures of four walls.
std::vector<Plane> small_walls(const PlaneUnknowns& rig, const PlaneSensor& sensor,
                               Gaussian& random) {
  std::vector<Plane> planes;
  for (const double z : {1.6, 2.4, 2.8, 4.0}) {
    Plane plane{.name = "", .z_m = z, .disparity = {}, .cells = {}};
    const double from = sensor.cx_left * 0.4;
    for (double row = 60; row < 180; row += 24) {
      for (double left = from; left < 2 * sensor.cx_left - from; left += 24) {
        const double ray = (left - sensor.cx_left) * sensor.pixel_m / rig[4];
        const double tangent = std::tan(rig[2] - std::atan(ray));
        const double right = sensor.cx_right - std::tan(std::atan(rig[0] / z + tangent) - rig[1]) *
                                                   rig[3] / sensor.pixel_m;
        plane.cells.push_back({left, right + random.next(0.015), row});
      }
    }
    planes.push_back(std::move(plane));
  }
  pull(planes, sensor, random);
  return planes;
}

TEST(PlaneFit, TheModelIsTheAppliances) {
  dsp::StereoRig rig;
  rig.left = {.width = 640, .height = 480, .fx = 1500, .fy = 1500, .cx = 320, .cy = 240};
  rig.baseline_m = kTruth[0];
  rig.converging = dsp::Converging{.alpha_rad = kTruth[1],
                                   .beta_rad = kTruth[2],
                                   .f1_m = kTruth[3],
                                   .f2_m = kTruth[4],
                                   .pixel_m = kSensor.pixel_m,
                                   .cx_left = kSensor.cx_left,
                                   .cx_right = kSensor.cx_right};
  for (const double x : {0.0, 200.0, 400.0, 639.0}) {
    const PlaneCell cell{.left = x, .right = x - 40, .row = 0};
    EXPECT_NEAR(depth_of(kTruth.data(), kSensor.left_m(cell), kSensor.right_m(cell)),
                dsp::depth_of(rig, x, 40), 1e-9);
  }
}

TEST(PlaneFit, GenesFindWhatLevenbergMarquardtRefines) {
  const std::vector<Plane> planes = walls(kTruth, 0.1, 0.0, 0.0, 3);
  const GeneticResult genes = evolve(planes, kSensor, {}, {});
  const std::optional<PlaneFit> fit = refine(planes, kSensor, {}, genes.x);
  ASSERT_TRUE(fit);
  const double refined = depth_rms_m(planes, kSensor, fit->x);
  std::printf("figure: genes %.2f mm in %.1f s, refined %.2f mm, constant off by %.4f percent\n",
              genes.rms_m * 1000, genes.seconds, refined * 1000,
              (triangulation_constant(fit->x) / triangulation_constant(kTruth) - 1) * 100);
  EXPECT_LT(genes.rms_m, 3 * refined);
  EXPECT_LT(genes.seconds, 60);
  EXPECT_NEAR(triangulation_constant(fit->x) / triangulation_constant(kTruth), 1, 0.005);
  EXPECT_NEAR(zero_disparity_m(fit->x), zero_disparity_m(kTruth), 0.01);
}

TEST(PlaneFit, TheSameSeedGivesTheSameGenes) {
  const std::vector<Plane> planes = walls(kTruth, 0.1, 0.0, 0.0, 3);
  const GeneticOptions options{.generations = 40, .population = 40, .seed = 7};
  EXPECT_EQ(evolve(planes, kSensor, {}, options).x, evolve(planes, kSensor, {}, options).x);
}

TEST(PlaneFit, TheCovarianceIsThatOfTheErrorsAndSaysWhatPriorsTell) {
  constexpr int kSeeds = 40;
  double constant = 0;
  double difference = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Gaussian random(500 + seed);
    std::vector<Plane> planes = walls(kTruth, 0.1, 0.001, 0.005, 100 + seed);
    pull(planes, kSensor, random);
    const std::optional<PlaneFit> fit = refine(planes, kSensor, told(random), kTruth);
    ASSERT_TRUE(fit);
    const double off = triangulation_constant(fit->x) - triangulation_constant(kTruth);
    constant += off * off / (fit->constant_sigma * fit->constant_sigma);
    const double turned = (fit->x[1] - fit->x[2]) - (kTruth[1] - kTruth[2]);
    difference += turned * turned / (fit->difference_sigma * fit->difference_sigma);
    EXPECT_LT(fit->constant_sigma / triangulation_constant(fit->x), 0.002);
    // Disparities do not tell b by itself.
    EXPECT_GT(fit->sigma(0) / fit->x[0], 3 * fit->constant_sigma / triangulation_constant(fit->x));
  }
  // chi^2 of 40 degrees of freedom: 3 sigma are 0.67 of the mean.
  EXPECT_NEAR(constant / kSeeds, 1, 0.67);
  EXPECT_NEAR(difference / kSeeds, 1, 0.67);
}

TEST(PlaneFit, TheCovarianceHasWhatMatchesOfAWallShare) {
  constexpr PlaneSensor kSmall{
      .pixel_m = 11.2e-6, .cx_left = 159.5, .cx_right = 159.5, .cy = 119.5};
  constexpr int kSeeds = 40;
  std::array<double, kPlaneUnknowns + 1> squared{};
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Gaussian random(900 + seed);
    const PlanePriors priors = told(random);
    const std::optional<PlaneFit> fit =
        refine(small_walls(kTruth, kSmall, random), kSmall, priors, kTruth);
    ASSERT_TRUE(fit);
    for (std::size_t i = 0; i < kPlaneUnknowns; ++i) {
      squared[i] += std::pow((fit->x[i] - kTruth[i]) / fit->sigma(i), 2) / kSeeds;
    }
    const double turned = (fit->x[1] - fit->x[2]) - (kTruth[1] - kTruth[2]);
    squared[kPlaneUnknowns] += std::pow(turned / fit->difference_sigma, 2) / kSeeds;
  }
  std::printf("figure: small pictures of four walls, mean normalised squared errors:");
  for (const double value : squared) {
    std::printf(" %.2f", value);
  }
  std::printf(" (b alpha beta f1 f2, alpha - beta)\n");
  // Pointing is not drawn here: alpha and beta by themselves err less than their prior.
  EXPECT_NEAR(squared[0], 1, 0.67);
  EXPECT_NEAR(squared[3], 1, 0.67);
  EXPECT_NEAR(squared[4], 1, 0.67);
  EXPECT_NEAR(squared[kPlaneUnknowns], 1, 0.67);
  EXPECT_LT(squared[1], 1.67);
  EXPECT_LT(squared[2], 1.67);
}

TEST(PlaneFit, CellsAreThoseOfMatchesThatAgree) {
  dataset::Image<float> map(96, 48, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (x < 48) {
        map.view().at(x, y) = 10 + 0.01F * static_cast<float>(x);
      } else if (x < 72) {
        map.view().at(x, y) = static_cast<float>((x * 7 + y * 13) % 40);  // noise
      }
    }
  }
  const std::vector<PlaneCell> cells = cells_of(map);
  ASSERT_EQ(cells.size(), 4U);
  EXPECT_NEAR(cells[0].left, 11.5, 1e-9);
  EXPECT_NEAR(cells[0].left - cells[0].right, 10.115, 1e-5);
}

}  // namespace
}  // namespace stof::host
