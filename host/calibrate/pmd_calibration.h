#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/fit/line_fit.h"
#include "host/calibrate/fit/pmd_fit.h"

// From walls at known distances to the constants of a PMD sensor: what is estimated, what is kept,
// and what the data do not support.
namespace stof::host {

struct CalibrateOptions {
  FitParts parts;  // `emitter`: only where nobody says where the lights are; both it and
                   // `wall_turn` only where the walls ask for them
  bool noise = true;
  bool white = true;
  double albedo = 0.9;  // of the wall, for the amplitude of a white surface
  // Constants that are not estimated come from here; without, from the recordings' default.
  std::optional<dsp::PmdSensor> start;
  std::optional<bool> phase_falls;  // none: the data say
};

enum class StrayVerdict {
  kNone,       // the walls show none
  kUnknown,    // fewer than four distances: nobody can tell
  kCorrected,  // found and subtracted
  kSuspected,  // the walls show it, and it was not to be estimated
};

struct StrayReport {
  StrayVerdict verdict = StrayVerdict::kUnknown;
  std::complex<double> estimate;  // LSB of I, Q; whether or not it is subtracted
  double sigma = 0;
  double apparent_m = 0;  // where a surface of this phase would be
  double explains = 0;    // share of the misfit that is gone with it
};

// A wall that the others put elsewhere: its distance is mistyped, or it was moved.
struct WrongWall {
  std::string name;
  double z_m = 0;       // as told
  double likely_m = 0;  // by the other walls
  double sigma_m = 0;
  double explains = 0;  // share of the misfit that is gone where it stands there
};

// Residuals of more standard deviations than this are not what the model leaves.
inline constexpr double kLargestMisfit = 2;

struct PmdCalibration {
  dsp::PmdSensor sensor;  // fixed_pattern refers to `pattern`
  std::vector<std::int16_t> pattern;
  PmdModel model;
  FitParts parts;  // what was estimated, and kept, in the end
  std::optional<LineFit> line;
  StrayReport stray;
  // The likeliest first, and those that explain half as much or more: one of them, as a rule.
  std::vector<WrongWall> wrong_walls;
  SampleNoise noise;
  bool noise_fitted = false;
  std::optional<dsp::SigmaPolynomial> sigma;
  double scale_sigma = 0;
  double misfit = 0;      // of the readings, in standard deviations: near 1 where the model holds
  double widest_gap = 0;  // of the phases that the walls cover, turns
  std::size_t readings = 0;
  WallData data;

  bool explains_the_walls() const noexcept {
    return misfit <= kLargestMisfit && wrong_walls.empty();
  }

  PmdCalibration() = default;
  PmdCalibration(PmdCalibration&&) = default;  // keeps pattern's storage
  PmdCalibration& operator=(PmdCalibration&&) = default;
  PmdCalibration(const PmdCalibration&) = delete;
  PmdCalibration& operator=(const PmdCalibration&) = delete;
};

inline constexpr std::size_t kFewestWalls = 3;  // at as many distances

// `camera` has what the recordings know: lens, modulation, dark, saturation, emitters. One line
// where the walls are at fewer than three distances or have no usable pixel.
dataset::Loaded<PmdCalibration> calibrate_pmd(const dsp::PmdSensor& camera, std::vector<Wall> walls,
                                              const CalibrateOptions& options);

}  // namespace stof::host
