#include "host/calibrate/pmd_calibration.h"

#include <cmath>

#include <gtest/gtest.h>

#include "host/calibrate/wall_view.h"
#include "tests/host/calibrate/wall_simulator.h"

namespace stof::host {
namespace {

using test::pattern_of;
using test::record;
using test::record_walls;
using test::SimulatedCamera;

const std::vector<double> kDistances{0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8,
                                     2.1, 2.4, 2.7, 3.0, 3.3, 3.6, 4.0};
constexpr int kFrames = 12;

dsp::PmdSensor known_of(const SimulatedCamera& camera) {
  return record(camera, 1, 1, 1).recording.calibration.pmd;
}

CalibrateOptions everything() {
  return {.parts = {.emitter = true, .wall_turn = true},
          .start = std::nullopt,
          .phase_falls = std::nullopt};
}

// An ordinary camera, with wiggling of other harmonics than 4.
SimulatedCamera ordinary() {
  SimulatedCamera camera;
  camera.offset_m = 0.731;
  camera.wiggling.sine[3] = 0.020;
  camera.wiggling.cosine[3] = -0.011;
  camera.wiggling.sine[4] = 0.006;
  camera.wiggling.cosine[1] = 0.009;
  camera.pattern_m = 0.006;
  return camera;
}

PmdCalibration calibrated(const SimulatedCamera& camera, const CalibrateOptions& options,
                          std::uint64_t seed = 1) {
  dataset::Loaded<PmdCalibration> found = calibrate_pmd(
      known_of(camera), record_walls(camera, kDistances, kFrames, 1000 * seed), options);
  EXPECT_TRUE(found) << found.error().message;
  return std::move(*found);
}

// Through the appliance's converter, at distances between those that were fitted to.
void expect_true_distances(const SimulatedCamera& camera, const PmdCalibration& found,
                           double relative) {
  for (const double z : {0.9, 1.5, 2.25, 2.85, 3.45}) {
    const WallView score = view_wall(found.sensor, record(camera, z, 16, 77), Frames::kAll);
    EXPECT_GT(score.valid, 0.95) << z;
    EXPECT_NEAR(score.error_m, 0, relative * z) << "wall at " << z;
    EXPECT_NEAR(score.predicted_m / score.spread_m, 1, 0.25) << "wall at " << z;
  }
}

double rms_difference(const std::vector<double>& turns, double turn_m,
                      const std::vector<double>& metres) {
  double sum = 0;
  for (std::size_t p = 0; p < metres.size(); ++p) {
    const double difference = turns[p] * turn_m - metres[p];
    sum += difference * difference;
  }
  return std::sqrt(sum / static_cast<double>(metres.size()));
}

TEST(CalibratePmd, FindsLineWigglingAndPatternOfAnotherCamera) {
  const SimulatedCamera camera = ordinary();
  const PmdCalibration found = calibrated(camera, everything());
  EXPECT_FALSE(found.model.phase_falls);
  EXPECT_EQ(found.model.scale, 1);
  EXPECT_EQ(found.stray.verdict, StrayVerdict::kNone);
  EXPECT_TRUE(found.model.emitters.empty());
  EXPECT_FALSE(found.parts.wall_turn);
  expect_true_distances(camera, found, 0.001);
  // The table, where the walls are: phases 0.12 to 0.85 of 5 m. Its mean is the offset's.
  for (double phi = 0.15; phi < 0.8; phi += 0.01) {
    const double table = found.model.wiggling.at(phi) + found.model.offset;
    const double truth = (camera.wiggling.at(phi) + camera.offset_m) / found.model.turn_m;
    EXPECT_NEAR(wrapped(table - truth) * found.model.turn_m, 0, 0.002) << phi;
  }
  EXPECT_LT(rms_difference(found.model.pattern, found.model.turn_m, pattern_of(camera)), 0.0015);
}

TEST(CalibratePmd, FindsThatThePhaseFalls) {
  SimulatedCamera camera = ordinary();
  camera.phase_falls = true;
  camera.f_mod_hz = 20'000'000;
  const PmdCalibration found = calibrated(camera, everything(), 2);
  EXPECT_TRUE(found.sensor.phase_falls);
  expect_true_distances(camera, found, 0.001);
}

TEST(CalibratePmd, FindsAScaleThatTheWallsAskFor) {
  for (const double scale : {0.95, 1.077}) {
    SimulatedCamera camera = ordinary();
    camera.scale = scale;
    const PmdCalibration found = calibrated(camera, everything(), 3);
    expect_true_distances(camera, found, 0.0015);
    EXPECT_NEAR(found.model.scale, scale, 0.02);
  }
}

TEST(CalibratePmd, FindsStrayLightAndSubtractsIt) {
  SimulatedCamera camera = ordinary();
  for (const std::complex<double> stray : {std::complex<double>(40, -90), {-12, 5}}) {
    camera.stray = stray;
    const PmdCalibration found = calibrated(camera, everything(), 4);
    ASSERT_EQ(found.stray.verdict, StrayVerdict::kCorrected);
    EXPECT_NEAR(found.model.stray.real(), stray.real(), 0.03 * std::abs(stray) + 0.5);
    EXPECT_NEAR(found.model.stray.imag(), stray.imag(), 0.03 * std::abs(stray) + 0.5);
    expect_true_distances(camera, found, 0.002);
    camera.phase_falls = true;
  }
}

TEST(CalibratePmd, SaysThatThereIsStrayLightWhichItWasNotAskedToFind) {
  SimulatedCamera camera = ordinary();
  camera.stray = {40, -90};
  CalibrateOptions options = everything();
  options.parts.stray = false;
  const PmdCalibration found = calibrated(camera, options, 5);
  EXPECT_EQ(found.stray.verdict, StrayVerdict::kSuspected);
  EXPECT_EQ(found.model.stray, 0.0);
  EXPECT_GT(found.misfit, 1.5);
}

TEST(CalibratePmd, FindsStrayLightAloneAndKeepsTheRest) {
  SimulatedCamera camera = ordinary();
  const PmdCalibration clean = calibrated(camera, everything(), 6);
  camera.stray = {60, 30};
  CalibrateOptions options = everything();
  options.start = clean.sensor;
  options.parts = {.offset = false, .scale = false, .wiggling = false, .pattern = false};
  options.noise = options.white = false;
  dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(known_of(camera), record_walls(camera, {1, 2, 3, 4}, 4, 600), options);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->stray.verdict, StrayVerdict::kCorrected);
  EXPECT_EQ(found->sensor.frequency.wiggling, clean.sensor.frequency.wiggling);
  EXPECT_EQ(found->pattern, clean.pattern);
  EXPECT_EQ(found->sensor.noise_lsb, clean.sensor.noise_lsb);
  expect_true_distances(camera, *found, 0.002);
}

TEST(CalibratePmd, FindsWhereOneLightIs) {
  SimulatedCamera camera = ordinary();
  camera.emitters = {{-0.10, 0.05, 0}};
  const PmdCalibration found = calibrated(camera, everything(), 7);
  ASSERT_EQ(found.model.emitters.size(), 1U);
  EXPECT_NEAR(found.model.emitters[0][0], -0.10, 0.02);
  EXPECT_NEAR(found.model.emitters[0][1], 0.05, 0.02);
  EXPECT_FALSE(found.parts.wall_turn);
  expect_true_distances(camera, found, 0.0015);
}

// A camera that is turned in its rig, before walls that face the rig.
TEST(CalibratePmd, TellsWallsThatDoNotFaceItFromALight) {
  SimulatedCamera camera = ordinary();
  camera.wall_turn = {0.028, -0.026};
  const PmdCalibration found = calibrated(camera, everything(), 12);
  EXPECT_TRUE(found.model.emitters.empty());
  ASSERT_TRUE(found.parts.wall_turn);
  EXPECT_NEAR(found.model.wall_turn[0], 0.028, 0.002);
  EXPECT_NEAR(found.model.wall_turn[1], -0.026, 0.002);
  EXPECT_LT(rms_difference(found.model.pattern, found.model.turn_m, pattern_of(camera)), 0.0025);
  camera.wall_turn = {};
  expect_true_distances(camera, found, 0.0015);
}

TEST(CalibratePmd, FindsALightBeforeWallsThatDoNotFaceIt) {
  SimulatedCamera camera = ordinary();
  camera.emitters = {{-0.10, 0.05, 0}};
  camera.wall_turn = {0.028, -0.026};
  const PmdCalibration found = calibrated(camera, everything(), 13);
  ASSERT_EQ(found.model.emitters.size(), 1U);
  EXPECT_NEAR(found.model.emitters[0][0], -0.10, 0.03);
  EXPECT_NEAR(found.model.emitters[0][1], 0.05, 0.03);
  EXPECT_NEAR(found.model.wall_turn[0], 0.028, 0.004);
  EXPECT_NEAR(found.model.wall_turn[1], -0.026, 0.004);
}

TEST(CalibratePmd, TakesTheLightsAsGiven) {
  SimulatedCamera camera = ordinary();
  camera.emitters = {{-0.12, 0, 0}, {0.12, 0, 0}};
  dsp::PmdSensor known = known_of(camera);
  known.emitter_count = 2;
  known.emitters = {{{-0.12, 0, 0}, {0.12, 0, 0}}};
  const dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(known, record_walls(camera, kDistances, kFrames, 8000), everything());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->sensor.emitter_count, 2);
  expect_true_distances(camera, *found, 0.001);
}

TEST(CalibratePmd, FindsTheAmplitudeOfAWhiteSurface) {
  const SimulatedCamera camera = ordinary();
  const PmdCalibration found = calibrated(camera, everything(), 9);
  EXPECT_NEAR(found.sensor.white_lsb, camera.white_lsb, 0.03 * camera.white_lsb);
}

TEST(CalibratePmd, RefusesTooFewDistances) {
  const SimulatedCamera camera = ordinary();
  const dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(known_of(camera), record_walls(camera, {1, 2, 2}, 2, 1), everything());
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("at 2 distance(s)"), std::string::npos);
}

TEST(CalibratePmd, RefusesWallsThatSaturate) {
  SimulatedCamera camera = ordinary();
  camera.white_lsb = 1e6;
  const dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(known_of(camera), record_walls(camera, {1, 2, 3}, 2, 1), everything());
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("saturated"), std::string::npos);
}

TEST(CalibratePmd, SaturatedPixelsDropOut) {
  SimulatedCamera camera = ordinary();
  camera.white_lsb = 2500;  // saturates the middle of walls nearer than 1.2 m
  const PmdCalibration found = calibrated(camera, everything(), 10);
  for (const double z : {1.5, 2.25, 2.85, 3.45}) {
    const WallView score = view_wall(found.sensor, record(camera, z, 16, 78), Frames::kAll);
    EXPECT_NEAR(score.error_m, 0, 0.001 * z);
  }
}

}  // namespace
}  // namespace stof::host
