#include "dsp/calib/pmd/pmd_tables.h"

#include <cmath>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

FrequencyTables tables_of(const PmdSensor& sensor) {
  return frequency_tables(sensor, sensor.frequency);
}

TEST(PmdTables, SaturateLimitsThatLieOutsideSamples) {
  PmdSensor sensor;
  sensor.saturation_lsb = 1 << 20;
  sensor.under_lsb = -1;
  sensor.electrons_per_lsb = 1e-3;
  sensor.frequency.stray_i_lsb = 1e7;
  sensor.frequency.stray_q_lsb = -1e7;
  const PhaseLimits limits = limits_at(tables_of(sensor), kReferenceIntegration);
  EXPECT_EQ(limits.saturation, 65535);
  EXPECT_EQ(limits.lowest, 0);  // never
  EXPECT_EQ(limits.asymmetry_slope_q8, kMaxAsymmetrySlopeQ8);
  EXPECT_EQ(limits.stray_i, 32767);
  EXPECT_EQ(limits.stray_q, -32767);
  EXPECT_EQ(limits_at(tables_of({}), 256).ratio_q16, 39322U);  // the chapter's 30 percent
}

TEST(PmdTables, ScaleStrayLightWithTheIntegrationTime) {
  PmdSensor sensor;
  sensor.frequency.stray_i_lsb = 53.086;
  sensor.frequency.stray_q_lsb = -161.2;
  const FrequencyTables frequency = tables_of(sensor);
  for (const double times : {0.0625, 0.25, 1.0, 2.5, 60.0}) {
    const PhaseLimits limits = limits_at(frequency, static_cast<IntegrationQ8>(256 * times));
    // Half a unit of rounding, and 1/512 LSB of the reference's.
    EXPECT_NEAR(limits.stray_i, 53.086 * times, 0.5 + times / 512) << times;
    EXPECT_NEAR(limits.stray_q, -161.2 * times, 0.5 + times / 512) << times;
  }
}

// (A0 + A2 - A1 - A3)^2 above 36 variances: 4 (off / g + suppressed / g + n^2 + 1/12).
TEST(PmdTables, ScaleTheAsymmetryLimitWithTheIntegrationTime) {
  PmdSensor sensor;
  sensor.electrons_per_lsb = 60;
  sensor.noise_lsb = 5;
  sensor.suppressed_lsb = 300;
  const FrequencyTables frequency = tables_of(sensor);
  for (const double times : {0.25, 1.0, 4.0}) {
    const PhaseLimits limits = limits_at(frequency, static_cast<IntegrationQ8>(256 * times));
    EXPECT_NEAR(limits.asymmetry_base, 36 * 4 * (25 + 1 / 12.0 + times * 300 / 60), 1) << times;
    EXPECT_EQ(limits.asymmetry_slope_q8, std::lround(36 * 4 * 256 / 60.0));
  }
  sensor.suppressed_lsb = 1e12;
  EXPECT_EQ(limits_at(tables_of(sensor), 65535).asymmetry_base, 0xFFFFFFFFU);
}

// 15 mm a kelvin: 131.16 phase units.
TEST(PmdTables, MoveTheOffsetWithTheTemperature) {
  PmdSensor sensor;
  sensor.frequency.offset_m = 1;
  sensor.frequency.offset_m_per_k = 0.015;
  sensor.reference_c = 30;
  const FrequencyTables frequency = tables_of(sensor);
  EXPECT_EQ(global_at(frequency, std::nullopt), 8744);
  EXPECT_EQ(global_at(frequency, 30 * 256), 8744);
  EXPECT_EQ(global_at(frequency, 40 * 256), 8744 + 1312);
  EXPECT_EQ(global_at(frequency, 20 * 256), 8744 - 1312);
  EXPECT_EQ(global_at(frequency, 30 * 256 + 128), 8744 + 66);        // half a kelvin
  EXPECT_EQ(global_at(frequency, -70 * 256), 65536 + 8744 - 13116);  // wraps
}

TEST(PmdTables, DropWholeTurnsOfAnOffset) {
  PmdSensor sensor;
  sensor.frequency.offset_m = 1 - 3 * 299792458.0 / 40e6;
  EXPECT_EQ(tables_of(sensor).correction.global, 8744);
}

TEST(PmdTables, RepeatAfterATurnTimesTheScale) {
  PmdSensor sensor;
  EXPECT_EQ(range_tables(sensor, turn_m(sensor.frequency)).range, 29979U);
  EXPECT_EQ(range_tables(sensor, turn_m(sensor.frequency)).widest, 14989);
  sensor.scale = 1.01;
  EXPECT_EQ(range_tables(sensor, turn_m(sensor.frequency)).range, 30279U);
  sensor.scale = 1;
  sensor.frequency.modulation = {1'000'000};
  EXPECT_EQ(range_tables(sensor, turn_m(sensor.frequency)).range, 599585U);
  EXPECT_EQ(range_tables(sensor, turn_m(sensor.frequency)).widest, 65535);
}

}  // namespace
}  // namespace stof::dsp
