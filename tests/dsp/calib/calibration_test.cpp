#include "dsp/calib/calibration.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

Calibration usable() {
  Calibration c;
  c.stereo = {.left = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 319.5, .cy = 239.5},
              .baseline_m = 0.12,
              .doff_px = 0};
  c.pmd.lens = {.width = 64, .height = 16, .fx = 45, .fy = 45, .cx = 31.5, .cy = 7.5};
  return c;
}

TEST(Calibration, UsableOneHasNoProblem) { EXPECT_EQ(problem(usable()), std::string()); }

TEST(Calibration, StereoOnlyNeedsNoPmd) {
  Calibration c = usable();
  c.pmd = {};
  EXPECT_EQ(problem(c), std::string());
}

TEST(Calibration, EveryUnusableNumberIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Calibration c = usable();
  c.stereo.left.fx = nan;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.stereo.baseline_m = 0;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.pmd_to_stereo.rotation[0] = 0.9;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.pmd_to_stereo.translation_m[1] = nan;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  const std::vector<std::int16_t> short_map(10);
  c.pmd.fixed_pattern = short_map;
  EXPECT_NE(problem(c), std::string());
}

// Each changes one thing of a sensor with two frequencies, lights and a polynomial of sigma; the
// message says which.
TEST(Calibration, EveryUnusableNumberOfThePmdCameraIsNamed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  Calibration good = usable();
  good.pmd.second = PmdFrequency{.modulation = Hertz{18'750'000}};
  good.pmd.emitter_count = 2;
  good.pmd.emitters = {{{-0.12, 0, 0}, {0.12, 0, 0}, {kNan, 0, 0}, {9, 9, 9}}};
  good.pmd.sigma_polynomial = SigmaPolynomial{.a = -0.02, .b = 2.6e-3, .c = 2.8e-5};
  ASSERT_EQ(problem(good), std::string());  // lights above the number are not looked at
  using Change = void (*)(PmdSensor&);
  constexpr std::pair<Change, const char*> kBad[] = {
      {[](PmdSensor& s) { s.lens.k3 = kNan; }, "lens"},
      {[](PmdSensor& s) { s.lens.p1 = kNan; }, "lens"},
      {[](PmdSensor& s) { s.lens.p2 = kEndless; }, "lens"},
      {[](PmdSensor& s) { s.frequency.modulation.value = 999'999; }, "1 to 200 MHz"},
      {[](PmdSensor& s) { s.frequency.modulation.value = 200'000'001; }, "1 to 200 MHz"},
      {[](PmdSensor& s) { s.frequency.min_modulation_ratio = 1.01; }, "ratio"},
      {[](PmdSensor& s) { s.frequency.offset_m = kNan; }, "offset"},
      {[](PmdSensor& s) { s.frequency.offset_m_per_k = -1.1; }, "offset"},
      {[](PmdSensor& s) { s.frequency.stray_i_lsb = kNan; }, "stray"},
      {[](PmdSensor& s) { s.frequency.stray_q_lsb = -40000; }, "stray"},
      {[](PmdSensor& s) { s.second->modulation.value = 0; }, "1 to 200 MHz"},
      {[](PmdSensor& s) { s.second->stray_q_lsb = kEndless; }, "stray"},
      {[](PmdSensor& s) { s.second->modulation.value = 20'000'000; }, "not below"},
      {[](PmdSensor& s) { s.second->modulation.value = 25'000'000; }, "not below"},
      {[](PmdSensor& s) { s.second->modulation.value = 18'750'001; }, "whole numbers"},
      {[](PmdSensor& s) { s.dark_lsb = -1; }, "dark"},
      {[](PmdSensor& s) { s.saturation_lsb = 0; }, "saturates"},
      {[](PmdSensor& s) { s.under_lsb = 4095; }, "saturates"},
      {[](PmdSensor& s) { s.dark_lsb = 4095; }, "not below its saturation"},
      {[](PmdSensor& s) { s.electrons_per_lsb = 1e12; }, "noise model"},
      {[](PmdSensor& s) { s.noise_lsb = 65536; }, "noise model"},
      {[](PmdSensor& s) { s.suppressed_lsb = 1e8; }, "noise model"},
      {[](PmdSensor& s) { s.white_lsb = 1e8; }, "white"},
      {[](PmdSensor& s) { s.lens.fx = 1e-9; }, "lens has no size, a focal length"},
      {[](PmdSensor& s) { s.lens.cx = 1e9; }, "lens"},
      {[](PmdSensor& s) { s.lens.k1 = -1e9; }, "lens"},
      {[](PmdSensor& s) { s.min_amplitude_lsb = -1; }, "amplitude"},
      {[](PmdSensor& s) { s.electrons_per_lsb = 0; }, "noise model"},
      {[](PmdSensor& s) { s.noise_lsb = kEndless; }, "noise model"},
      {[](PmdSensor& s) { s.suppressed_lsb = -1; }, "noise model"},
      {[](PmdSensor& s) { s.asymmetry_sigmas = 0; }, "asymmetry"},
      {[](PmdSensor& s) { s.white_lsb = -1; }, "white"},
      {[](PmdSensor& s) { s.integration_us = kNan; }, "integration"},
      {[](PmdSensor& s) { s.integration_us = 1e8; }, "integration"},
      {[](PmdSensor& s) { s.scale = 0.4; }, "straight line"},
      {[](PmdSensor& s) { s.scale = 2.1; }, "straight line"},
      {[](PmdSensor& s) { s.scale = kNan; }, "straight line"},
      {[](PmdSensor& s) { s.shift_m = -101; }, "straight line"},
      {[](PmdSensor& s) { s.reference_c = kNan; }, "temperature"},
      {[](PmdSensor& s) { s.sigma_polynomial->b = -1; }, "sigma"},
      {[](PmdSensor& s) { s.sigma_polynomial->c = kNan; }, "sigma"},
      {[](PmdSensor& s) { s.emitter_count = -1; }, "lights"},
      {[](PmdSensor& s) { s.emitter_count = 5; }, "lights"},
      {[](PmdSensor& s) { s.emitter_count = 3; }, "2 m"},
      {[](PmdSensor& s) { s.emitters[1] = {1.5, 1.5, 0}; }, "2 m"},
  };
  for (const auto& [change, fact] : kBad) {
    Calibration c = good;
    change(c.pmd);
    EXPECT_NE(std::string(problem(c)).find(fact), std::string::npos) << fact << ": " << problem(c);
  }
}

TEST(Calibration, EveryUnusableNumberOfThePairIsNamed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  using Change = void (*)(StereoRig&);
  constexpr std::pair<Change, const char*> kBad[] = {
      {[](StereoRig& r) { r.baseline_m = 500; }, "baseline"},
      {[](StereoRig& r) { r.baseline_m = 1e-9; }, "baseline"},
      {[](StereoRig& r) { r.baseline_m = kNan; }, "baseline"},
      {[](StereoRig& r) { r.doff_px = -1000; }, "disparity offset"},
      {[](StereoRig& r) { r.doff_px = kNan; }, "disparity offset"},
      {[](StereoRig& r) { r.left.cy = 1e9; }, "left camera"},
      {[](StereoRig& r) { r.left.fx = 1e9; }, "left camera"},
  };
  for (const auto& [change, fact] : kBad) {
    Calibration c = usable();
    change(c.stereo);
    EXPECT_NE(std::string(problem(c)).find(fact), std::string::npos) << fact << ": " << problem(c);
  }
}

TEST(Calibration, ALensOfTheRawPairHasUsableDistortion) {
  Calibration c = usable();
  RawPair& pair = c.stereo.raw.emplace();
  pair.left = pair.right = c.stereo.left;
  pair.left_to_right.translation_m = {-0.1, 0, 0};
  pair.right.p1 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(complete(c.stereo), std::string());
  EXPECT_NE(problem(c), std::string());
}

TEST(Calibration, AMirrorIsNotARotation) {
  Calibration c = usable();
  c.pmd_to_stereo.rotation = {1, 0, 0, 0, -1, 0, 0, 0, 1};
  EXPECT_NE(problem(c), std::string());
}

TEST(Calibration, IncludesTheRawOrConvergingPair) {
  Calibration c = usable();
  c.stereo.converging =
      Converging{.f1_m = 0.004, .f2_m = 0.004, .pixel_m = 8e-6, .cx_left = 319.5, .cx_right = 300};
  EXPECT_EQ(complete(c.stereo), std::string());
  EXPECT_EQ(problem(c), std::string());
  EXPECT_EQ(c.stereo.doff_px, -19.5);
  c.stereo.converging->pixel_m = 0;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  RawPair& pair = c.stereo.raw.emplace();
  pair.left = pair.right = c.stereo.left;
  pair.left_to_right.translation_m = {-0.1, 0, 0};
  EXPECT_EQ(complete(c.stereo), std::string());
  EXPECT_EQ(problem(c), std::string());
  EXPECT_NEAR(c.stereo.baseline_m, 0.1, 1e-12);
  pair.left_to_right.translation_m = {0, 0, 0};
  EXPECT_NE(problem(c), std::string());
}

TEST(WigglingTable, HoldsFourPeriodsOfTheAmplitude) {
  // 0.0386 rad is 403 steps of 1/65536 turn; sin(4 phi) peaks at a sixteenth of a turn.
  const WigglingTable table = fourth_harmonic_table(0.0386);
  EXPECT_EQ(table[0], 0);
  EXPECT_EQ(table[8], std::lround(0.0386 / (2 * std::numbers::pi) * 65536));
  EXPECT_EQ(table[24], -table[8]);
  for (std::size_t i = 0; i < 96; ++i) {
    EXPECT_EQ(table[i], table[i + 32]);
  }
}

// The table is read by what was measured, which 4 samples of a correlation with these harmonics
// are: not by the phase that it is to give.
TEST(WigglingTable, GivesBackThePhaseThatHarmonicsBent) {
  for (const auto& [kappa3, kappa5] : {std::pair(0.05, 0.0114), std::pair(-0.08, 0.03),
                                       std::pair(0.0, 0.06), std::pair(0.0, 0.0)}) {
    PmdSensor sensor;
    sensor.frequency.wiggling = wiggling_of_harmonics(kappa3, kappa5);
    double worst = 0;
    for (int i = 0; i < 65536; i += 7) {
      const double p = i * 2 * std::numbers::pi / 65536;
      const double measured =
          std::atan2(std::sin(p) - kappa3 * std::sin(3 * p) + kappa5 * std::sin(5 * p),
                     std::cos(p) + kappa3 * std::cos(3 * p) + kappa5 * std::cos(5 * p)) /
          (2 * std::numbers::pi) * kWigglingSteps;
      const double whole = std::floor(measured);
      const auto at = [&](double step) {
        return sensor.frequency
            .wiggling[static_cast<std::size_t>(static_cast<int>(step) & (kWigglingSteps - 1))];
      };
      const double wiggle = at(whole) + (at(whole + 1) - at(whole)) * (measured - whole);
      worst = std::max(worst, std::abs(std::remainder(
                                  measured * (65536.0 / kWigglingSteps) - wiggle - i, 65536.0)));
    }
    // Straight lines between 128 steps leave an eighth of the squared step times the curvature, of
    // the fourth and the eighth harmonic; and steps and result are rounded.
    const double amplitude = std::abs(kappa5 - kappa3);
    constexpr double kStep = 2 * std::numbers::pi / kWigglingSteps;
    const double lines = kStep * kStep / 8 * (16 * amplitude + 128 * amplitude * amplitude);
    EXPECT_LE(worst, lines / (2 * std::numbers::pi) * 65536 + 1.5) << kappa3 << ", " << kappa5;
  }
}

}  // namespace
}  // namespace stof::dsp
