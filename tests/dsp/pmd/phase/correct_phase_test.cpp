#include "dsp/pmd/phase/correct_phase.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/pmd_tables.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

Phase run(const PhaseCorrection& correction, int phase, std::span<const std::int16_t> fixed = {}) {
  const Phase in = static_cast<Phase>(phase);
  Phase out = 0;
  best::correct_phase({&in, 1}, fixed, correction, {&out, 1});
  return out;
}

TEST(CorrectPhase, ChangesNothingWithoutCorrections) {
  for (int phase = 0; phase < 65536; phase += 257) {
    EXPECT_EQ(run({}, phase), phase);
  }
}

TEST(CorrectPhase, WrapsAndNeverClips) {
  EXPECT_EQ(run({.global = 8744}, 17488), 8744);
  EXPECT_EQ(run({.global = 8744}, 1000), 65536 + 1000 - 8744);
  const std::int16_t fixed = -2000;
  EXPECT_EQ(run({}, 64000, {&fixed, 1}), 64000 + 2000 - 65536);
}

TEST(CorrectPhase, NegatesAFallingPhaseFirst) {
  const std::int16_t fixed = 300;
  EXPECT_EQ(run({.phase_falls = true, .global = 100}, 65536 - 17488, {&fixed, 1}),
            17488 - 300 - 100);
  EXPECT_EQ(run({.phase_falls = true}, 0), 0);
}

// 1 m of fixed pattern is 8744 of a turn at 20 MHz and 8198 at 18.75 MHz.
TEST(CorrectPhase, SubtractsTheSameMetresOfTheSecondFrequency) {
  PmdSensor sensor;
  sensor.second = PmdFrequency{.modulation = {18'750'000}};
  const PhaseCorrection second = frequency_tables(sensor, *sensor.second).correction;
  for (const int metres : {-3, -1, 1, 2}) {
    const std::int16_t fixed = static_cast<std::int16_t>(metres * 8744);
    const int expected = static_cast<int>(std::lround(metres * 8744 * 18.75 / 20));
    EXPECT_NEAR(static_cast<std::int16_t>(run(second, 0, {&fixed, 1})), -expected, 1) << metres;
  }
  EXPECT_EQ(frequency_tables(sensor, sensor.frequency).correction.pattern_scale_q14,
            kPatternScaleOne);
}

TEST(CorrectPhase, KeepsEveryPatternOfTheFirstFrequencyAsItIs) {
  for (int fixed = -32768; fixed < 32768; fixed += 77) {
    const std::int16_t pattern = static_cast<std::int16_t>(fixed);
    EXPECT_EQ(run({}, 0, {&pattern, 1}), static_cast<Phase>(-fixed));
  }
}

TEST(CorrectPhase, RemovesFourthHarmonicWigglingToTwoUnits) {
  PmdSensor sensor;  // 46 mm, as odd harmonics of an LED make it
  sensor.frequency.wiggling = fourth_harmonic_table(-0.0386);
  const PhaseCorrection correction = frequency_tables(sensor, sensor.frequency).correction;
  double worst = 0;
  for (int i = 0; i < 65536; i += 7) {
    const double measured = i * 2 * std::numbers::pi / 65536;
    const double truth = i + 0.0386 * std::sin(4 * measured) / (2 * std::numbers::pi) * 65536;
    worst = std::max(worst, std::abs(std::remainder(run(correction, i) - truth, 65536.0)));
  }
  // Half a unit each of two table roundings and of the result; 0.2 mm, 1.75 units, of
  // interpolation.
  EXPECT_LE(worst, 3.25);
}

// The last step of the table leads back to the first.
TEST(CorrectPhase, ReadsTheTableAllTheWayRound) {
  PmdSensor sensor;
  sensor.frequency.wiggling[0] = 100;
  sensor.frequency.wiggling[127] = 40;
  const PhaseCorrection correction = frequency_tables(sensor, sensor.frequency).correction;
  EXPECT_EQ(run(correction, 127 * 512), 127 * 512 - 40);
  EXPECT_EQ(run(correction, 127 * 512 + 256), 127 * 512 + 256 - 70);
  EXPECT_EQ(run(correction, 0), 65536 - 100);
}

TEST(CorrectPhase, EqualsReferenceForEveryLengthAndExtreme) {
  for (const bool falls : {false, true}) {
    for (const bool pattern : {false, true}) {
      test::check_kernel([&](test::KernelCase& c) {
        const auto phase = c.array<Phase>(c.length(), 0, 65535);
        const auto fixed = c.array<std::int16_t>(pattern ? c.length() : 0, -32768, 32767);
        PhaseCorrection correction{
            .phase_falls = falls,
            .global = static_cast<Phase>(c.draw(0, 65535)),
            .pattern_scale_q14 = static_cast<std::uint16_t>(c.draw(0, 65535))};
        for (WigglingStep& step : correction.wiggling) {
          step = {static_cast<std::int16_t>(c.draw(-32768, 32767)),
                  static_cast<std::int16_t>(c.draw(-32768, 32767))};
        }
        const auto corrected = c.array<Phase>(c.length());
        c.run([&] { best::correct_phase(phase, fixed, correction, corrected); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
