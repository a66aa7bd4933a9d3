#pragma once

#include <array>
#include <optional>

#include "host/calibrate/pmd_calibration.h"
#include "host/calibrate/report/pmd_report.h"
#include "host/evaluate/pmd/recordings/find.h"

// Walls at known distances: what a calibration leaves, what lights beside the lens and stray light
// do, and what the appliance says about it. All by its own converter.
namespace stof::host {

inline constexpr std::size_t kPmdFlags = 8;
// "saturated", "under range", ... in the order of PmdFlag's bits.
const std::array<const char*, kPmdFlags>& pmd_flag_names();

// What one recording of a wall becomes. Errors are of Z, shares of the readings in the middle of
// the picture (middle_of). Maps are means over the frames; NaN where no frame carries a distance.
struct WallView {
  double error_m = 0;  // NaN: no reading carries a distance
  double valid = 0;
  std::array<double, kPmdFlags> flagged{};
  double ratio = 0;  // mean modulation ratio of the middle
  double amp2 = 0;
  dataset::Image<float> z_m;
  dataset::Image<float> sigma_m;  // of a radial reading
  dataset::Image<float> modulation;
  dataset::Image<float> valid_share;  // of the frames
};
// Stray and suppressed light of the sensor grow with the recording's exposure.
WallView view_wall(const dsp::PmdSensor& sensor, const WallRecording& wall, Frames frames);

// One distance of a wall with stray light.
struct StrayRow {
  std::string name;
  double z_m = 0;
  WallView before;  // by the recording's own constants
  WallView after;   // the same with the estimated phasor
};

struct WallStudy {
  std::filesystem::path folder;
  PmdReport report;  // straight line alone and full calibration
  PmdCalibration calibration;
  bool given = false;  // the calibration is --calibration's, and so judged on all frames
  // Where the calibration finds stray light:
  std::vector<StrayRow> stray;
  double stray_i_lsb = 0;
  double stray_q_lsb = 0;
  double stray_sigma_lsb = 0;
  double stray_apparent_m = 0;
  // One wall far enough for the straight line, before any calibration and after, for pictures.
  std::string shown;
  double shown_m = 0;
  WallView plain;
  WallView full;
  std::vector<WallView> views;  // of report.rows, calibrated
};

// Calibrates on `fitted` frames and judges on the others.
dataset::Loaded<WallStudy> study_walls(const PmdSet& set, const PmdSources& sources, Frames fitted);

}  // namespace stof::host
