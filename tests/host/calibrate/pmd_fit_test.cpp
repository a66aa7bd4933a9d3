#include "host/calibrate/fit/pmd_fit.h"

#include <gtest/gtest.h>

#include "dsp/base/units.h"
#include "tests/host/calibrate/wall_simulator.h"

namespace stof::host {
namespace {

test::SimulatedCamera bent_camera() {
  test::SimulatedCamera camera;
  camera.scale = 1.01;
  camera.wiggling.sine[3] = 0.020;
  camera.wiggling.cosine[3] = -0.011;
  camera.pattern_m = 0.006;
  camera.stray = {6, -4};
  return camera;
}

WallData walls_of(const test::SimulatedCamera& camera) {
  return {.lens = camera.lens,
          .rays = rays_of(camera.lens),
          .walls =
              test::record_walls(camera, {0.6, 0.9, 1.2, 1.5, 1.8, 2.2, 2.6, 3.0, 3.5, 4.0}, 12, 7),
          .noise = {.electrons_per_lsb = 40, .noise_lsb = 4, .suppressed_lsb = 0}};
}

PmdModel begin_of(const test::SimulatedCamera& camera) {
  PmdModel model;
  model.turn_m = dsp::kLightMetresPerSecond / (2.0 * camera.f_mod_hz);
  return model;
}

// What a solver finds is the data's, not its own. 1e-6 of a turn is 5 um, far below every figure
// that is told; the steps end where the cost changes by less than 1e-9 of itself.
TEST(FitModel, EndsAtTheSameConstantsFromWhereverItBegins) {
  const test::SimulatedCamera camera = bent_camera();
  const WallData data = walls_of(camera);
  const PmdModel near = begin_of(camera);
  PmdModel far = near;
  far.offset = 0.08;
  far.scale = 1.04;
  far.stray = {-30, 20};
  far.wiggling.sine[1] = 0.01;
  const FitResult a = fit_model(data, {}, near);
  const FitResult b = fit_model(data, {}, far);
  EXPECT_TRUE(a.converged);
  EXPECT_TRUE(b.converged);
  EXPECT_NEAR(a.cost / b.cost, 1, 1e-6);
  EXPECT_NEAR(a.model.offset, b.model.offset, 1e-5);
  EXPECT_NEAR(a.model.scale, b.model.scale, 1e-5);
  EXPECT_NEAR(std::abs(a.model.stray - b.model.stray), 0, 0.01);
  for (std::size_t h = 0; h < kHarmonics; ++h) {
    EXPECT_NEAR(a.model.wiggling.sine[h], b.model.wiggling.sine[h], 1e-5) << "harmonic " << h + 1;
  }
  for (std::size_t p = 0; p < data.rays.size(); ++p) {
    ASSERT_NEAR(a.model.pattern[p], b.model.pattern[p], 1e-5) << "pixel " << p;
  }
}

TEST(FitModel, LeavesWhatItIsNotAskedToFind) {
  const test::SimulatedCamera camera = bent_camera();
  PmdModel begin = begin_of(camera);
  begin.scale = 1.02;
  begin.stray = {3, 2};
  begin.wiggling.cosine[2] = 0.001;
  const FitResult found = fit_model(
      walls_of(camera),
      {.offset = true, .scale = false, .wiggling = false, .pattern = false, .stray = false}, begin);
  EXPECT_EQ(found.model.scale, begin.scale);
  EXPECT_EQ(found.model.stray, begin.stray);
  EXPECT_EQ(found.model.wiggling.cosine, begin.wiggling.cosine);
  EXPECT_NE(found.model.offset, begin.offset);
}

}  // namespace
}  // namespace stof::host
