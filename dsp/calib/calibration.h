#pragma once

#include <optional>

#include "dsp/calib/pinhole.h"
#include "dsp/calib/pmd_sensor.h"

// The calibration of a rig. Metres, pixels, x right, y down, z forward; doubles, because tables
// are built from it once at start and no frame is computed from it directly.
namespace stof::dsp {

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

struct Calibration {
  StereoRig stereo;
  PmdSensor pmd;
  RigidTransform pmd_to_stereo;  // into the axes that StereoRig describes
};

// Computes what follows from rig.raw or rig.converging; a rig with neither stays as it is, and a
// second call changes nothing. Empty, or what is wrong with the rig, for a message.
const char* complete(StereoRig& rig) noexcept;

// Empty ("") when every number of a complete() calibration can be computed with (rotations that are
// orthonormal within 1e-3, ...) and lies in the range of docs/CALIBRATION.md, else what is wrong,
// for a message.
const char* problem(const Calibration& calibration) noexcept;

}  // namespace stof::dsp
