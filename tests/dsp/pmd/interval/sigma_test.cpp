#include "dsp/pmd/interval/sigma.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/pmd_tables.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

struct Quality {
  int sigma;
  int ratio;
};

Quality quality(const NoiseModel& model, std::uint16_t amp2, std::uint16_t offset) {
  QuarterMm sigma = 0;
  std::uint8_t ratio = 0;
  best::sigma_and_ratio({&amp2, 1}, {&offset, 1}, model, {&sigma, 1}, {&ratio, 1});
  return {sigma, ratio};
}

int shot(const NoiseModel& model, std::uint16_t amp2, std::uint16_t offset) {
  return quality(model, amp2, offset).sigma;
}

int ratio_of(std::uint16_t amp2, std::uint16_t offset) { return quality({}, amp2, offset).ratio; }

int on_curve(const SigmaCurve& curve, QuarterMm distance) {
  QuarterMm sigma = 7;
  best::curve_sigma({&distance, 1}, curve, {&sigma, 1});
  return sigma;
}

int both(QuarterMm sigma, QuarterMm other) {
  best::combine_sigma({&other, 1}, {&sigma, 1});
  return sigma;
}

// Kuhnert & Stommel 2006, eq. 15 through 0.52, 1.62, 3.28, 5.48 cm at 1, 2, 3, 4 m.
constexpr SigmaPolynomial kChapter{.a = -0.03, .b = 0.00275, .c = 2.75e-5};

// sigma = K_s sqrt(off / g + n^2) / amp2 with K_s = sqrt(2) 4000 c / (4 pi f) = 6747.6 at 20 MHz;
// the rounding of samples adds 1/12 LSB^2.
TEST(ShotSigma, IsThatOfTheNoiseModel) {
  PmdSensor sensor;
  sensor.electrons_per_lsb = 50;
  sensor.noise_lsb = 6;
  const NoiseModel model =
      noise_at(frequency_tables(sensor, sensor.frequency), kReferenceIntegration);
  const double expected = 6747.6 * std::sqrt(1000 / 50.0 + 36 + 1 / 12.0) / 1000;
  EXPECT_NEAR(shot(model, 1000, 1000), expected, 0.51);  // 50.5: 12.6 mm
  EXPECT_EQ(shot(model, 0, 32767), 65535);               // no amplitude: saturates
  EXPECT_EQ(shot(model, 65535, 0), 1);                   // never better than the unit
}

// The shot noise of suppressed light stays, and grows with the time it was collected.
TEST(ShotSigma, CountsSuppressedLightByIntegrationTime) {
  PmdSensor sensor;
  sensor.electrons_per_lsb = 50;
  sensor.noise_lsb = 6;
  sensor.suppressed_lsb = 2000;  // 40 LSB^2
  const FrequencyTables frequency = frequency_tables(sensor, sensor.frequency);
  for (const double times : {0.25, 1.0, 4.0}) {
    const double expected = 6747.6 * std::sqrt(1000 / 50.0 + 36 + 1 / 12.0 + 40 * times) / 1000;
    const IntegrationQ8 integration = static_cast<IntegrationQ8>(256 * times);
    EXPECT_NEAR(shot(noise_at(frequency, integration), 1000, 1000), expected, 0.51) << times;
  }
}

// One pixel's light falls with the square of distance: 190,000 electrons at 1 m, contrast 0.45,
// 340 electrons of fixed noise, 5.2 percent apart at most.
TEST(ShotSigma, FollowsTheMeasuredCurveOfTheChapter) {
  constexpr double kElectronsPerLsb = 20;
  constexpr double kContrast = 0.45;
  PmdSensor sensor;
  sensor.electrons_per_lsb = kElectronsPerLsb;
  sensor.noise_lsb = 340 / kElectronsPerLsb;
  const NoiseModel model =
      noise_at(frequency_tables(sensor, sensor.frequency), kReferenceIntegration);
  constexpr std::array<double, 4> kSigmaCm{0.52, 1.62, 3.28, 5.48};
  for (int z = 1; z <= 4; ++z) {
    const double light = 190000.0 / (z * z) / kElectronsPerLsb;
    const int sigma = shot(model, static_cast<std::uint16_t>(2 * kContrast * light),
                           static_cast<std::uint16_t>(light));
    const double measured = kSigmaCm[static_cast<std::size_t>(z - 1)];
    EXPECT_NEAR(sigma / 40.0, measured, 0.08 * measured) << z << " m";
  }
}

TEST(ModulationRatio, ComesInSteps) {
  EXPECT_EQ(ratio_of(600, 1000), 77);  // A 300 of 1000: 76.8 / 256
  EXPECT_EQ(ratio_of(200, 1000), 26);
  EXPECT_EQ(ratio_of(0, 1000), 0);
  EXPECT_EQ(ratio_of(3000, 1500), 255);  // A = offset is the most there is
  EXPECT_EQ(ratio_of(200, 0), 255);      // offset 0 counts as 1
  EXPECT_EQ(ratio_of(1, 0), 128);
  EXPECT_EQ(ratio_of(0, 0), 0);
  // Half a step rounds to even: 128 * 1 / 256 and 128 * 3 / 256.
  EXPECT_EQ(ratio_of(1, 256), 0);
  EXPECT_EQ(ratio_of(3, 256), 2);
}

TEST(CurveSigma, IsThePolynomialOfTheChapter) {
  const SigmaCurve curve = sigma_curve(kChapter);
  constexpr std::array<double, 4> kSigmaCm{0.52, 1.62, 3.28, 5.48};
  for (int z = 1; z <= 4; ++z) {
    const double cm = on_curve(curve, static_cast<QuarterMm>(z * 4000)) / 40.0;
    EXPECT_NEAR(cm, kSigmaCm[static_cast<std::size_t>(z - 1)], 0.04) << z << " m";
  }
  for (int d = 1; d <= 65535; d += 61) {
    const double z = d / 40.0;
    const double expected = 40 * (kChapter.a + kChapter.b * z + kChapter.c * z * z);
    // Half a unit each of two table roundings and of the result, a tenth of interpolation.
    EXPECT_NEAR(on_curve(curve, static_cast<QuarterMm>(d)), std::max(expected, 1.0), 1.6) << d;
  }
}

TEST(CurveSigma, OfNoDistanceIsZeroAndOfAnyOtherAtLeastOne) {
  const SigmaCurve none = sigma_curve({});
  EXPECT_EQ(on_curve(none, 0), 0);
  EXPECT_EQ(on_curve(none, 1), 1);
  EXPECT_EQ(on_curve(sigma_curve({.a = -100}), 40000), 1);
  EXPECT_EQ(on_curve(sigma_curve({.a = 1e9}), 65535), 65535);
  EXPECT_EQ(on_curve(sigma_curve({.c = 1}), 65535), 65535);
}

TEST(CombineSigma, IsThatOfTheWeightedMean) {
  EXPECT_EQ(both(100, 100), 71);
  EXPECT_EQ(both(30, 40), 24);
  EXPECT_EQ(both(1, 65535), 1);
  EXPECT_EQ(both(65535, 65535), 46340);
  EXPECT_EQ(both(1, 1), 1);  // never better than the unit
}

TEST(Sigma, EqualsReferenceForEveryLengthAndExtreme) {
  for (const int most : {3, 65535}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const auto amp2 = c.array<std::uint16_t>(n, 0, most);
      const auto offset = c.array<std::uint16_t>(n, 0, c.draw(0, 1) == 0 ? 3 : 65535);
      const NoiseModel model{static_cast<float>(c.draw(0, 1000000)) / 7,
                             static_cast<float>(c.draw(0, 1000000)) / 7};
      const auto sigma = c.array<QuarterMm>(n), combined = c.array<QuarterMm>(n, 1, most);
      const auto ratio = c.array<std::uint8_t>(n);
      c.run([&] { best::sigma_and_ratio(amp2, offset, model, sigma, ratio); });
      const auto other = c.array<QuarterMm>(n, 1, most);
      c.run([&] { best::combine_sigma(other, combined); });
      SigmaCurve curve{};
      for (SigmaStep& step : curve) {
        step.value = c.draw(0, 65535);
        step.gain = c.draw(0, 65535) - step.value;
      }
      const auto distance = c.array<QuarterMm>(n, 0, most), on_curve = c.array<QuarterMm>(n);
      c.run([&] { best::curve_sigma(distance, curve, on_curve); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
