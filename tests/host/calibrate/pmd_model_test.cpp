#include "host/calibrate/fit/pmd_model.h"

#include <cmath>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

TEST(PmdModel, HalfTheWayOfOneLightIsTheSpecificationsFormulaReadBackwards) {
  const std::array<dsp::Emitter, 1> light{{{0.12, -0.03, 0.01}}};
  const std::array<double, 3> ray{0.48, -0.36, 0.8};
  for (const double d : {0.4, 1.0, 3.0}) {
    const double way = 2 * half_path(light, ray, d);  // ct
    const double square = 0.12 * 0.12 + 0.03 * 0.03 + 0.01 * 0.01;
    const double along = 0.12 * 0.48 + 0.03 * 0.36 + 0.01 * 0.8;
    EXPECT_NEAR((way * way - square) / (2 * (way - along)), d, 1e-12);
  }
  EXPECT_EQ(half_path({}, ray, 2.5), 2.5);
}

TEST(PmdModel, WigglingIsUndoneByItsInverse) {
  WigglingCurve curve;
  curve.sine[3] = 0.01;
  curve.cosine[6] = 0.004;
  curve.table = {};
  for (double phi2 = 0; phi2 < 1; phi2 += 0.01) {
    const double phi1 = curve.inverse(phi2);
    EXPECT_NEAR(phi1 - curve.at(phi1), phi2, 1e-8);
  }
  EXPECT_NEAR(curve.slope(0), 0.01 * 8 * std::acos(-1.0), 2e-3);
}

TEST(PmdModel, ASensorBecomesAModelAndTheSameSensorAgain) {
  const std::vector<std::int16_t> pattern{-300, 0, 17, 250};
  dsp::PmdSensor sensor;
  sensor.phase_falls = true;
  sensor.scale = 1.01;
  sensor.shift_m = -0.02;
  sensor.frequency.offset_m = 0.4;
  sensor.frequency.stray_i_lsb = 12;
  sensor.frequency.stray_q_lsb = -7.5;
  sensor.frequency.wiggling = dsp::fourth_harmonic_table(0.04);
  sensor.emitter_count = 1;
  sensor.emitters[0] = {0.1, 0, 0};
  sensor.fixed_pattern = pattern;
  dsp::PmdSensor again;
  std::vector<std::int16_t> stored;
  put_model(model_of(sensor), again, stored);
  EXPECT_EQ(stored, pattern);
  EXPECT_EQ(again.frequency.wiggling, sensor.frequency.wiggling);
  EXPECT_EQ(again.phase_falls, sensor.phase_falls);
  EXPECT_EQ(again.scale, sensor.scale);
  EXPECT_EQ(again.shift_m, sensor.shift_m);
  EXPECT_NEAR(again.frequency.offset_m, sensor.frequency.offset_m, 1e-12);
  EXPECT_EQ(again.frequency.stray_i_lsb, sensor.frequency.stray_i_lsb);
  EXPECT_EQ(again.frequency.stray_q_lsb, sensor.frequency.stray_q_lsb);
  EXPECT_EQ(again.emitter_count, 1);
  EXPECT_EQ(again.emitters, sensor.emitters);
}

}  // namespace
}  // namespace stof::host
