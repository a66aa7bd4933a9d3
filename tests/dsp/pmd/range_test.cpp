#include "dsp/pmd/range.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/pmd_tables.h"
#include "dsp/pmd/converter.h"
#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Reading {
  int distance;
  int sigma;
  friend bool operator==(const Reading&, const Reading&) = default;
};

Reading run(const RangeParams& params, Phase phase, std::uint16_t amp2 = 1000,
            std::uint16_t offset = 1000, std::uint8_t flags = 0,
            std::span<const std::int16_t> fixed = {}) {
  QuarterMm distance = 0;
  QuarterMm sigma = 0;
  ref::range({&phase, 1}, {&amp2, 1}, {&offset, 1}, {&flags, 1}, fixed, params, {&distance, 1},
             {&sigma, 1});
  return {distance, sigma};
}

TEST(Range, OneTurnAtTwentyMegahertzIs29979QuarterMillimetres) {
  const RangeParams params = range_params({});
  EXPECT_EQ(params.range, 29979);
  EXPECT_EQ(run(params, 32768).distance, 14990);  // half of it, rounded up
  EXPECT_EQ(run(params, 17488).distance, 8000);   // a plane at 2 m
  EXPECT_EQ(run(params, 65535).distance, 29979);
}

TEST(Range, WritesAMeasuredZeroAsOneBecauseZeroMeansNone) {
  EXPECT_EQ(run(range_params({}), 0).distance, 1);
  EXPECT_EQ(run(range_params({}), 1).distance, 1);
}

TEST(Range, LeavesOutPixelsThatAreNotToBeTrusted) {
  for (int bit = 0; bit < 8; ++bit) {
    const std::uint8_t flag = static_cast<std::uint8_t>(1 << bit);
    const bool missing = (flag & kPmdMissing) != 0;
    EXPECT_EQ(run(range_params({}), 20000, 1000, 1000, flag) == (Reading{0, 0}), missing) << bit;
  }
}

TEST(Range, WrapsOffsetsAndNegatesAFallingPhase) {
  PmdSensor sensor;
  sensor.tone.offset_m = 1;
  const RangeParams later = range_params(sensor);
  EXPECT_EQ(run(later, 17488).distance, 4000);              // 2 m less 1 m
  EXPECT_NEAR(run(later, 4372).distance, 29979 - 2000, 1);  // 0.5 m less 1 m wraps
  sensor.tone.offset_m = 1 - 3 * 299792458.0 / 40e6;             // whole turns change nothing
  EXPECT_EQ(run(range_params(sensor), 17488).distance, 4000);
  sensor = {};
  sensor.phase_falls = true;
  EXPECT_EQ(run(range_params(sensor), static_cast<Phase>(-17488)).distance, 8000);
  const std::int16_t fixed = 8744;  // 1 m
  EXPECT_EQ(run(range_params({}), 17488, 1000, 1000, 0, {&fixed, 1}).distance, 4000);
}

TEST(Range, RemovesFourthHarmonicWigglingToAQuarterMillimetre) {
  PmdSensor sensor;
  sensor.tone.wiggling = fourth_harmonic_table(-0.0386);  // 46 mm, as odd harmonics of an LED make it
  const RangeParams params = range_params(sensor);
  double worst = 0;
  for (int i = 0; i < 65536; i += 7) {
    const double measured = i * 2 * std::numbers::pi / 65536;
    const double truth = measured + 0.0386 * std::sin(4 * measured);
    const double expected = truth / (2 * std::numbers::pi) * params.range;
    if (expected > 2 && expected < params.range - 2.0) {
      worst = std::max(worst, std::abs(run(params, static_cast<Phase>(i)).distance - expected));
    }
  }
  // Half a unit of distance, half a unit of each of two table roundings, 0.2 mm of interpolation.
  EXPECT_LE(worst, 2.0);
}

// sigma = K_s sqrt(off / g + n^2) / amp2 with K_s = sqrt(2) 4000 c / (4 pi f) = 6747.6 at 20 MHz;
// the rounding of samples adds 1/12 LSB^2.
TEST(Range, SigmaIsThatOfTheShotNoiseModel) {
  PmdSensor sensor;
  sensor.electrons_per_lsb = 50;
  sensor.noise_lsb = 6;
  const RangeParams params = range_params(sensor);
  const double expected = 6747.6 * std::sqrt(1000 / 50.0 + 36 + 1 / 12.0) / 1000;
  EXPECT_NEAR(run(params, 20000).sigma, expected, 0.51);  // 50.5: 12.6 mm
  sensor.suppressed_lsb = 2000;                           // its shot noise stays: 40 LSB^2 more
  const double brighter = 6747.6 * std::sqrt(1000 / 50.0 + 76 + 1 / 12.0) / 1000;
  EXPECT_NEAR(run(range_params(sensor), 20000).sigma, brighter, 0.51);
  EXPECT_EQ(run(params, 20000, 0, 32767).sigma, 65535);  // no amplitude: saturates
  EXPECT_EQ(run(params, 20000, 65535, 0).sigma, 1);      // never better than the unit
}

// The chapter's equation 15: 0.52, 1.62, 3.28, 5.48 cm at 1, 2, 3, 4 m (z and sigma in cm). One
// pixel's light falls with the square of distance: 190,000 electrons at 1 m, contrast 0.45,
// 340 electrons of fixed noise, 5.2 percent apart at most.
TEST(Range, SigmaFollowsTheMeasuredCurveOfTheChapter) {
  constexpr double kElectronsPerLsb = 20;
  constexpr double kContrast = 0.45;
  PmdSensor sensor;
  sensor.electrons_per_lsb = kElectronsPerLsb;
  sensor.noise_lsb = 340 / kElectronsPerLsb;
  const RangeParams params = range_params(sensor);
  constexpr std::array<double, 4> kSigmaCm{0.52, 1.62, 3.28, 5.48};
  for (int z = 1; z <= 4; ++z) {
    const double light = 190000.0 / (z * z) / kElectronsPerLsb;
    const Reading reading =
        run(params, static_cast<Phase>(z * 8744), static_cast<std::uint16_t>(2 * kContrast * light),
            static_cast<std::uint16_t>(light));
    const double measured = kSigmaCm[static_cast<std::size_t>(z - 1)];
    EXPECT_NEAR(reading.sigma / 40.0, measured, 0.08 * measured) << z << " m";
  }
}

TEST(Range, NeonEqualsReferenceForEveryLengthAndExtreme) {
  for (std::size_t n = 0; n <= 70; ++n) {
    for (std::uint64_t variant = 0; variant < 4; ++variant) {
      test::Random random(n * 4 + variant);
      test::GuardedBuffer<Phase> phase(n);
      test::GuardedBuffer<std::uint16_t> amp2(n), offset(n);
      test::GuardedBuffer<std::uint8_t> flags(n);
      test::GuardedBuffer<std::int16_t> fixed(variant % 2 == 0 ? n : 0);
      test::GuardedBuffer<QuarterMm> distance_a(n), distance_b(n), sigma_a(n), sigma_b(n);
      random.fill(phase.span());
      random.fill(amp2.span(), 0, variant == 0 ? 3 : 65535);
      random.fill(offset.span());
      random.fill(fixed.span());
      for (std::uint8_t& flag : flags.span()) {
        flag = random.between(0, 3) == 0 ? static_cast<std::uint8_t>(random.next()) : 0;
      }
      RangeParams params;
      params.phase_falls = variant >= 2;
      params.global = static_cast<Phase>(random.next());
      params.range = static_cast<std::uint16_t>(variant == 3 ? 65535 : random.between(1, 65535));
      params.noise_slope = static_cast<float>(random.between(0, 1000000));
      params.noise_base = static_cast<float>(random.between(0, 1000000));
      for (WigglingStep& step : params.wiggling) {
        step = {static_cast<std::int16_t>(random.next()), static_cast<std::int16_t>(random.next())};
      }
      ref::range(phase.span(), amp2.span(), offset.span(), flags.span(), fixed.span(), params,
                 distance_a.span(), sigma_a.span());
      neon::range(phase.span(), amp2.span(), offset.span(), flags.span(), fixed.span(), params,
                  distance_b.span(), sigma_b.span());
      ASSERT_TRUE(std::ranges::equal(distance_a.span(), distance_b.span())) << n << "/" << variant;
      ASSERT_TRUE(std::ranges::equal(sigma_a.span(), sigma_b.span())) << n << "/" << variant;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
