#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dsp/calib/calibration.h"
#include "tests/support/random.h"

// Calibrations that make no sense, for tests of how they are stored.
namespace stof::test {

// Every field has another value, so that a swap shows.
inline dsp::Calibration some_calibration(std::span<const std::int16_t> pattern,
                                         bool options = false) {
  dsp::Calibration c;
  double next = 0.1;
  const auto fill = [&next](dsp::Pinhole& lens, int width, int height) {
    lens.width = width;
    lens.height = height;
    for (double* number : {&lens.fx, &lens.fy, &lens.cx, &lens.cy, &lens.k1, &lens.k2}) {
      *number = next *= -1.7;
    }
  };
  fill(c.stereo.left, 640, 480);
  c.stereo.baseline_m = 0.16;
  c.stereo.doff_px = -31.5;
  fill(c.pmd.lens, 5, 3);
  if (options) {
    dsp::RawPair& pair = c.stereo.raw.emplace();
    fill(pair.left, 641, 481);
    fill(pair.right, 642, 482);
    for (double& element : pair.left_to_right.rotation) {
      element = next *= 1.05;
    }
    for (double& element : pair.left_to_right.translation_m) {
      element = next *= -1.05;
    }
    c.stereo.converging = dsp::Converging{.alpha_rad = 0.25,
                                          .beta_rad = -0.125,
                                          .f1_m = 8.5e-3,
                                          .f2_m = 8.25e-3,
                                          .pixel_m = 5.6e-6,
                                          .cx_left = 311.25,
                                          .cx_right = 330.5};
  }
  c.pmd.frequency.modulation = dsp::Hertz{18'750'000};
  c.pmd.phase_falls = true;
  c.pmd.dark_lsb = 101.5;
  c.pmd.saturation_lsb = 4000;
  c.pmd.under_lsb = -7;
  c.pmd.min_amplitude_lsb = 9;
  c.pmd.frequency.min_modulation_ratio = 0.25;
  c.pmd.asymmetry_sigmas = 5.5;
  c.pmd.electrons_per_lsb = 61;
  c.pmd.noise_lsb = 4.75;
  c.pmd.suppressed_lsb = 12;
  c.pmd.frequency.offset_m = -0.03125;
  test::Random random(1);
  random.fill(std::span<std::int16_t>(c.pmd.frequency.wiggling));
  for (double& element : c.pmd_to_stereo.rotation) {
    element = next *= 1.1;
  }
  for (double& element : c.pmd_to_stereo.translation_m) {
    element = next *= -1.1;
  }
  c.pmd.fixed_pattern = pattern;
  return c;
}

// Beside them what version 3 added.
inline dsp::Calibration newest_calibration(std::span<const std::int16_t> pattern,
                                           bool options = false) {
  dsp::Calibration c = some_calibration(pattern, options);
  double next = 1000.25;
  const auto lens = [&next](dsp::Pinhole& of) {
    for (double* number : {&of.k3, &of.p1, &of.p2}) {
      *number = next++;
    }
  };
  lens(c.stereo.left);
  lens(c.pmd.lens);
  if (options) {
    lens(c.stereo.raw->left);
    lens(c.stereo.raw->right);
    c.pmd.sigma_polynomial = dsp::SigmaPolynomial{.a = -0.25, .b = 0.5, .c = 0.125};
    dsp::PmdFrequency& second = c.pmd.second.emplace();
    second.modulation = dsp::Hertz{17'500'000};
    for (double* number : {&second.min_modulation_ratio, &second.offset_m, &second.offset_m_per_k,
                           &second.stray_i_lsb, &second.stray_q_lsb}) {
      *number = next++;
    }
    test::Random random(3);
    random.fill(std::span<std::int16_t>(second.wiggling));
  }
  dsp::PmdSensor& pmd = c.pmd;
  for (double* number :
       {&pmd.frequency.offset_m_per_k, &pmd.frequency.stray_i_lsb, &pmd.frequency.stray_q_lsb,
        &pmd.integration_us, &pmd.reference_c, &pmd.scale, &pmd.shift_m, &pmd.white_lsb}) {
    *number = next++;
  }
  pmd.emitter_count = 3;
  for (dsp::Emitter& emitter : pmd.emitters) {
    for (double& coordinate : emitter) {
      coordinate = next++;
    }
  }
  return c;
}

inline std::vector<std::int16_t> some_pattern(std::size_t count = 15) {
  std::vector<std::int16_t> pattern(count);
  test::Random random(2);
  random.fill(std::span(pattern));
  return pattern;
}

}  // namespace stof::test
