#pragma once

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/rig/extrinsics/wall_plane.h"
#include "host/calibrate/rig/target/lens_model.h"

// Where a PMD camera stands to a pair, from walls that both see at several tilts.
namespace stof::host {

struct SeenWall {
  std::string name;
  SeenPlane stereo;  // axes of the rectified left camera
  SeenPlane pmd;     // axes of the PMD camera
};

struct ExtrinsicOptions {
  double offset_sigma_m = 0.003;  // how far PMD distances may be off, all alike
  // And each knot's by itself (kRangeStepM): what a calibration leaves of the wiggling.
  double leftover_sigma_m = 0.001;
};

struct ExtrinsicFit {
  PoseUnknowns pmd_to_stereo{};  // X_stereo = R X_pmd + T
  // Of a small turn of the stereo axes (rad) and of T (m): R_true = exp(turn) R. From how far looks
  // scatter; times `misfit` where walls are off by much more than that tells.
  Eigen::Matrix<double, 6, 6> covariance;
  double offset_m = 0;  // by how much the PMD camera reads too far, found beside
  double offset_sigma_m = 0;
  double misfit = 0;  // chi^2 over its degrees of freedom: near 1 where walls are flat and sensors
                      // agree
  std::vector<double> wall_misfit;  // rms of each wall's three numbers, in standard deviations
  // By walls: how far the planes of both sensors lie off each other in the end, rms over the walls.
  double turned_rad = 0;
  double apart_m = 0;  // in the middle of the PMD picture

  // Empty where the walls are one for both sensors, or what they are not. Errors that the looks of
  // a wall share make every misfit larger than 1; what it comes to in degrees and mm is judged.
  std::string contradiction() const;
};

inline constexpr double kLargestTurnedRad = 0.4 * std::numbers::pi / 180;
inline constexpr double kLargestApartM = 0.004;

// None where there are fewer than three walls, or T does not follow from their tilts.
std::optional<ExtrinsicFit> fit_extrinsics(const std::vector<SeenWall>& walls,
                                           const ExtrinsicOptions& options);

// Which tilts are missing, a line each; empty: all there.
std::vector<std::string> missing_tilts(const std::vector<SeenWall>& walls);

// The turn and shift (6 numbers of ExtrinsicFit::covariance) from `fit` to `truth`.
Eigen::Matrix<double, 6, 1> difference(const PoseUnknowns& fit, const PoseUnknowns& truth);

}  // namespace stof::host
