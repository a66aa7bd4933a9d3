#pragma once

#include <complex>
#include <span>
#include <vector>

#include "host/calibrate/fit/pmd_model.h"
#include "host/calibrate/fit/pmd_noise.h"
#include "host/calibrate/walls/pmd_wall.h"

// The constants of a PmdModel from walls at known distances, by least squares.
namespace stof::host {

struct WallData {
  dsp::Pinhole lens;
  std::vector<std::array<double, 3>> rays;
  std::vector<Wall> walls;
  SampleNoise noise;  // weighs the readings
  double min_amplitude_lsb = 4;
  // One pixel of this many is looked at: constants that all pixels share need no more than a few
  // thousand.
  int every = 1;
};

inline constexpr std::size_t kNoWall = static_cast<std::size_t>(-1);

// Which constants are estimated; the others stay as they are.
struct FitParts {
  bool offset = true;
  bool scale = true;
  bool wiggling = true;
  bool pattern = true;
  bool stray = true;
  bool emitter = false;                // x and y of emitters[0], or half the spread of two
  bool wall_turn = false;              // of all walls, alike
  std::size_t shifted_wall = kNoWall;  // its distance is estimated, too
};

struct FitResult {
  PmdModel model;
  double cost = 0;  // robust, of residuals in standard deviations, half squares
  std::size_t readings = 0;
  // Standard deviations as the noise of the readings makes them.
  double scale_sigma = 0;
  double stray_sigma = 0;      // the larger of I and Q
  double wall_turn_sigma = 0;  // the larger of x and y
  double wall_shift_sigma = 0;
  bool converged = false;
};

// A reading of one pixel at one wall, ready to be compared with a model.
struct Observation {
  std::size_t pixel = 0;
  std::size_t wall = 0;
  std::complex<double> iq;  // conjugate where the phase falls
  double distance_m = 0;    // along the ray, of a wall that faces the camera
  double exposure = 1;
  double variance = 0;  // of I or Q, mean over the frames
  double sigma = 0;     // with what the model does not know; set by the fit
};

// The usable readings, pixel by pixel.
std::vector<Observation> observations(const WallData& data, bool phase_falls);

// Levenberg-Marquardt from `begin` (Ceres), Huber's loss. Each pixel's pattern is eliminated from
// the normal equations. Constants that the walls do not determine stay small: weak priors on scale
// and harmonics, and on the pattern one of the size that the pattern turns out to have.
FitResult fit_model(const WallData& data, const FitParts& parts, const PmdModel& begin);

}  // namespace stof::host
