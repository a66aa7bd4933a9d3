#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/units.h"

// What is known about a rig. Metres, pixels, x right, y down, z forward; doubles, because tables
// are built from it once at start and no frame is computed from it directly.
namespace stof::dsp {

// A central projection: u = fx x / z + cx, with radial distortion x_d = x (1 + k1 r^2 + k2 r^4),
// r^2 = x^2 + y^2, on the normalised plane. Pixel centres have integer coordinates.
struct Pinhole {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  double k1 = 0;
  double k2 = 0;
};

// Rectified pair: Z = left.fx * baseline_m / (d + doff_px), doff = cx_right - cx_left.
// left.k1 and left.k2 are 0.
struct StereoRig {
  Pinhole left;
  double baseline_m = 0;
  double doff_px = 0;
};

// W(phase), one turn in 128 steps, in units of 1/65536 turn: what wiggling adds to the phase.
inline constexpr int kWigglingSteps = 128;
using WigglingTable = std::array<std::int16_t, kWigglingSteps>;

// W(phi) = amplitude sin(4 phi): what odd harmonics kappa3, kappa5 of the correlation add to the
// phase, amplitude = kappa5 - kappa3 in radians (tof noise model: I + jQ ~ e^j + k3 e^-3j + k5
// e^5j).
WigglingTable fourth_harmonic_table(double amplitude_rad) noexcept;

struct PmdSensor {
  Pinhole lens;
  Hertz modulation{20'000'000};
  bool phase_falls = false;            // a camera whose phase falls with distance
  double dark_lsb = 0;                 // of one sample
  int saturation_lsb = 4095;           // a sample at or above it is saturated
  int under_lsb = 0;                   // a sample at or below it is under range
  int min_amplitude_lsb = 4;           // of amplitude A (amp2 = 2 A)
  double min_modulation_ratio = 0.30;  // A / (mean - dark), the chapter's 30 percent
  // |A0 + A2 - A1 - A3| above this many standard deviations of its noise: motion, changing light.
  double asymmetry_sigmas = 6;
  double electrons_per_lsb = 60;  // g of the noise model
  double noise_lsb = 5;           // n of the noise model: what a sample has without any light
  double suppressed_lsb = 0;  // mean ambient light that the sensor suppresses; its shot noise stays
  double offset_m = 0;        // global distance offset, subtracted
  WigglingTable wiggling{};
  // Distance offset of each pixel in 1/65536 turn, subtracted; width x height, row by row, or
  // empty. Borrowed: whoever made the calibration keeps it.
  std::span<const std::int16_t> fixed_pattern;
};

// X_stereo = R X_pmd + T. Row-major.
struct RigidTransform {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<double, 3> translation_m{};
};

struct Calibration {
  StereoRig stereo;
  PmdSensor pmd;
  RigidTransform pmd_to_stereo;
};

// Empty ("") when every number can be computed with (finite, positive focal lengths and baseline,
// a rotation that is orthonormal within 1e-3, ...), else what is wrong, for a message.
const char* problem(const Calibration& calibration) noexcept;

}  // namespace stof::dsp
