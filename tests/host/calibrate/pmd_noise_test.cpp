#include "host/calibrate/fit/pmd_noise.h"

#include <gtest/gtest.h>

#include "tests/host/calibrate/wall_simulator.h"

namespace stof::host {
namespace {

using test::record;
using test::record_walls;
using test::SimulatedCamera;

TEST(FitNoise, FindsGainAndFixedNoise) {
  SimulatedCamera camera;
  for (const auto& [gain, noise] : {std::pair{40.0, 4.0}, {15.0, 7.0}}) {
    camera.electrons_per_lsb = gain;
    camera.noise_lsb = noise;
    const std::optional<SampleNoise> found =
        fit_noise(record_walls(camera, {0.6, 1, 2, 3, 4}, 24, 5), {});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->electrons_per_lsb, gain, 0.05 * gain);
    EXPECT_NEAR(found->noise_lsb, noise, 0.05 * noise);
    EXPECT_EQ(found->suppressed_lsb, 0);
  }
}

TEST(FitNoise, KeepsTheSuppressedLightThatItCannotTellFromNoise) {
  SimulatedCamera camera;
  camera.noise_lsb = 5;
  const std::optional<SampleNoise> found =
      fit_noise(record_walls(camera, {0.6, 1, 2, 3, 4}, 24, 6), {.suppressed_lsb = 200});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->suppressed_lsb, 200);
  // 200 / 40 of the 25 LSB^2.
  EXPECT_NEAR(found->variance(0, 1), 25 + 1.0 / 12, 1.5);
}

TEST(FitNoise, TellsSuppressedLightByDifferentExposures) {
  const SimulatedCamera camera;
  std::vector<Wall> walls;
  for (const double exposure : {0.25, 1.0, 2.0}) {
    // Suppressed light adds variance alone: 300 LSB at the reference.
    SimulatedCamera lit = camera;
    lit.noise_lsb =
        std::sqrt(camera.noise_lsb * camera.noise_lsb + exposure * 300 / camera.electrons_per_lsb);
    for (const double z : {1.0, 2.0, 3.0}) {
      walls.push_back(summarise(record(lit, z, 24, 7, exposure), Frames::kAll));
    }
  }
  const std::optional<SampleNoise> found = fit_noise(walls, {});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->suppressed_lsb, 300, 60);
  EXPECT_NEAR(found->noise_lsb, camera.noise_lsb, 0.4);
}

TEST(FitNoise, SaysThatSingleFramesTellNothing) {
  EXPECT_FALSE(fit_noise(record_walls({}, {1, 2, 3}, 1, 8), {}));
  EXPECT_FALSE(fit_noise({}, {}));
}

TEST(FitSigma, IsThePolynomialItself) {
  // The chapter's eq. 15 at 1, 2, 3, 4 m.
  const dsp::SigmaPolynomial known{.a = 0.0125, .b = 0.0017, .c = 3.4e-5};
  std::vector<SigmaPoint> points;
  for (const double z : {1.0, 2.0, 3.0, 4.0}) {
    points.push_back({.z_m = z, .sigma_m = sigma_at(known, z)});
  }
  const std::optional<dsp::SigmaPolynomial> found = fit_sigma(points);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->a, known.a, 1e-9);
  EXPECT_NEAR(found->b, known.b, 1e-11);
  EXPECT_NEAR(found->c, known.c, 1e-13);
}

TEST(FitSigma, TakesThreeDistances) {
  EXPECT_FALSE(fit_sigma({}));
  EXPECT_FALSE(fit_sigma(std::vector<SigmaPoint>{{1, 0.01}, {2, 0.02}}));
  EXPECT_FALSE(fit_sigma(std::vector<SigmaPoint>{{1, 0.01}, {2, 0.02}, {2, 0.02}}));
}

}  // namespace
}  // namespace stof::host
