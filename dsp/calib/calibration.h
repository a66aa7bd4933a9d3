#pragma once

#include <array>
#include <cstdint>
#include <optional>
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

// X' = R X + T. Row-major.
struct RigidTransform {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<double, 3> translation_m{};
};

// The two cameras of a pair whose pictures are rectified before they are matched: both lenses as
// they are, of one size, and X_right = R X_left + T in the cameras' own axes (T is near
// (-baseline, 0, 0)).
struct RawPair {
  Pinhole left;
  Pinhole right;
  RigidTransform left_to_right;
};

// A pair adjusted by hand until rows correspond, whose axes converge and whose pictures are matched
// as they are (Kuhnert & Stommel 2006, section 2.5). In the plane of a row:
//   Z = baseline / (T_r - T_l)
//   T_r = tan(alpha + atan(-(x_right - cx_right) pixel / f1))
//   T_l = tan(beta + atan(-(x_left - cx_left) pixel / f2))
// Yaw and T are counted from the perpendicular of the baseline towards the left. A pair that
// converges at 5.31 m with baseline 0.20 m: alpha = -beta = atan(0.10 / 5.31).
struct Converging {
  double alpha_rad = 0;  // yaw of the right camera
  double beta_rad = 0;   // yaw of the left camera
  double f1_m = 0;       // focal length of the right camera
  double f2_m = 0;       // focal length of the left camera
  double pixel_m = 0;    // from one column to the next
  double cx_left = 0;    // principal columns, px
  double cx_right = 0;
};

// Where depth comes from. Z counts from the left camera's centre along the perpendicular of the
// baseline: the axes of the rectified left camera, whichever of the three rigs this is.
//   neither option     pictures are rectified: Z = left.fx * baseline_m / (d + doff_px),
//                      doff = cx_right - cx_left
//   raw                the same once the pictures are rectified; left, baseline_m and doff_px
//                      follow from it (complete())
//   converging         Z from both columns, baseline_m as above. left.fx, left.cx and doff_px
//                      follow from it: those of the parallel rig that is nearest to it around the
//                      principal columns, for what knows parallel rigs alone (the place of a PMD
//                      reading in the left picture, point clouds, the calibration packet)
// left.k1 and left.k2 are 0.
struct StereoRig {
  Pinhole left;
  double baseline_m = 0;
  double doff_px = 0;
  std::optional<RawPair> raw = std::nullopt;
  std::optional<Converging> converging = std::nullopt;
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

struct Calibration {
  StereoRig stereo;
  PmdSensor pmd;
  RigidTransform pmd_to_stereo;  // into the axes that StereoRig describes
};

// Computes what follows from rig.raw or rig.converging; a rig with neither stays as it is, and a
// second call changes nothing. Empty, or what is wrong with the rig, for a message.
const char* complete(StereoRig& rig) noexcept;

// Empty ("") when every number of a complete() calibration can be computed with (finite, positive
// focal lengths and baseline, rotations that are orthonormal within 1e-3, ...), else what is wrong,
// for a message.
const char* problem(const Calibration& calibration) noexcept;

}  // namespace stof::dsp
