#include "dsp/pmd/range/phase_to_distance.h"

#include <cmath>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/pmd_tables.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

std::uint32_t turned(std::uint32_t turn, Phase phase) {
  std::uint32_t out = 0;
  best::phase_to_distance({&phase, 1}, turn, {&out, 1});
  return out;
}

std::uint32_t on_line(const LinearDistanceCorrection& line, std::uint32_t distance) {
  best::correct_distance(line, {&distance, 1});
  return distance;
}

TEST(PhaseToDistance, OneTurnAtTwentyMegahertzIs29979QuarterMillimetres) {
  const std::uint32_t turn = frequency_tables({}, {}).turn;
  EXPECT_EQ(turn, 29979U);
  EXPECT_EQ(turned(turn, 32768), 14990U);  // half of it, rounded up
  EXPECT_EQ(turned(turn, 17488), 8000U);   // a plane at 2 m
  EXPECT_EQ(turned(turn, 65535), 29979U);
  EXPECT_EQ(turned(turn, 0), 0U);
}

// Above 16.38 m a turn is counted in 0.1 mm: 4 MHz, 37.474 m.
TEST(PhaseToDistance, CountsLongTurnsInTenthsOfAMillimetre) {
  PmdSensor sensor;
  sensor.frequency.modulation = {9'160'000};
  EXPECT_FALSE(has_long_range(sensor));
  EXPECT_EQ(frequency_tables(sensor, sensor.frequency).turn, 65457U);
  sensor.frequency.modulation = {9'140'000};
  EXPECT_TRUE(has_long_range(sensor));
  sensor.frequency.modulation = {4'000'000};
  const std::uint32_t turn = frequency_tables(sensor, sensor.frequency).turn;
  EXPECT_EQ(turn, 374741U);
  EXPECT_EQ(turned(turn, 32768), 187371U);
  EXPECT_EQ(turned(turn, 65535), 374735U);
  sensor.frequency.modulation = {1'000'000};
  EXPECT_EQ(turned(frequency_tables(sensor, sensor.frequency).turn, 65535), 1498939U);
}

TEST(LinearDistanceCorrection, ChangesNothingWhereScaleIsOneAndShiftZero) {
  EXPECT_TRUE(changes_nothing({}));
  EXPECT_TRUE(changes_nothing(range_tables({}, 7.49481145).line));
  for (const std::uint32_t d : {1U, 2U, 29979U, kMostUnits}) {
    EXPECT_EQ(on_line({}, d), d);
  }
}

// The chapter's eq. 14, z = -5.4022 phi + 672.5 cm for a count of 138.7 a turn: a falling phase,
// (5.4022 * 138.7) / 749.48 of the scale, and an offset of 672.5 cm less a whole turn of it.
TEST(LinearDistanceCorrection, IsTheChaptersFit) {
  PmdSensor sensor;
  sensor.phase_falls = true;
  sensor.scale = 5.4022 * 138.7 / 749.48;
  sensor.shift_m = 6.725 - 5.4022 * 1.387;
  const RangeTables tables = range_tables(sensor, turn_m(sensor.frequency));
  const FrequencyTables frequency = frequency_tables(sensor, sensor.frequency);
  for (const double count : {20.0, 60.0, 100.0, 120.0}) {
    const Phase phase = static_cast<Phase>(std::lround(count / 138.7 * 65536));
    Phase corrected = 0;
    best::correct_phase({&phase, 1}, {}, frequency.correction, {&corrected, 1});
    const double z_cm = on_line(tables.line, turned(frequency.turn, corrected)) / 40.0;
    EXPECT_NEAR(z_cm, -5.4022 * count + 672.5, 0.05) << count;
  }
  // 130 counts would lie 29.8 cm behind the camera: they are one turn further away.
  const std::uint32_t d =
      turned(frequency.turn, static_cast<Phase>(-std::lround(130 / 138.7 * 65536)));
  EXPECT_NEAR(on_line(tables.line, d) / 40.0, -5.4022 * 130 + 672.5 + 5.4022 * 138.7, 0.05);
}

TEST(LinearDistanceCorrection, NeverEndsAtNothing) {
  EXPECT_EQ(on_line({.shift = -500, .turn = 0}, 499), 1U);
  EXPECT_EQ(on_line({.shift = -500, .turn = 100}, 300), 1U);
  EXPECT_EQ(on_line({.shift = -500, .turn = 29979}, 500), 29979U);
  EXPECT_EQ(on_line({.shift = -500, .turn = 29979}, 501), 1U);
  EXPECT_EQ(on_line({.scale_q15 = 0}, 12345), 1U);
  EXPECT_EQ(on_line({.scale_q15 = LinearDistanceCorrection::kMostScale}, 0xFFFFFFFF), kMostUnits);
}

TEST(PhaseToDistance, EqualsReferenceForEveryLengthAndExtreme) {
  for (const std::uint32_t turn : {0U, 1U, 29979U, 65535U, 65536U, 1498962U, kMostUnits}) {
    test::check_kernel([&](test::KernelCase& c) {
      const auto phase = c.array<Phase>(c.length(), 0, 65535);
      const auto distance = c.array<std::uint32_t>(c.length());
      c.run([&] { best::phase_to_distance(phase, turn, distance); });
    });
  }
}

TEST(LinearDistanceCorrection, EqualsReferenceForEveryLengthAndExtreme) {
  constexpr int kMost = kMostUnits;
  for (int variant = 0; variant < 6; ++variant) {
    test::check_kernel([&](test::KernelCase& c) {
      const auto distance = c.array<std::uint32_t>(c.length());
      for (std::uint32_t& d : distance) {
        d >>= static_cast<unsigned>(variant * 6);
      }
      const LinearDistanceCorrection line{
          .scale_q15 = static_cast<std::uint32_t>(c.draw(0, LinearDistanceCorrection::kMostScale)),
          .shift = c.draw(-kMost, kMost) / (1 << (variant * 3)),
          .turn = static_cast<std::uint32_t>(c.draw(0, variant < 3 ? kMost : 40000))};
      c.run([&] { best::correct_distance(line, distance); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
