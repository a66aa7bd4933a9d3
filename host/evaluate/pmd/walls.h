#pragma once

#include <array>
#include <optional>

#include "host/calibrate/pmd_calibration.h"
#include "host/calibrate/report/pmd_report.h"
#include "host/evaluate/pmd/recordings/find.h"

// Walls at known distances: what a calibration leaves, what lights beside the lens and stray light
// do, and what the appliance says about it. All by its own converter.
namespace stof::host {

// "saturated", "under range", ... in the order of PmdFlag's bits.
const std::array<const char*, kPmdFlags>& pmd_flag_names();

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
  double shown_m = 0;
  WallView plain;
  WallView full;
};

// Calibrates on `fitted` frames and judges on the others.
dataset::Loaded<WallStudy> study_walls(const PmdSet& set, const PmdSources& sources, Frames fitted);

}  // namespace stof::host
