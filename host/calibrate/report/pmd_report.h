#pragma once

#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/calibrate/pmd_calibration.h"
#include "host/calibrate/wall_view.h"
#include "host/calibrate/walls/wall_folder.h"

// The quality of a calibration.
namespace stof::host {

struct WallRow {
  std::string name;
  double z_m = 0;
  double exposure = 1;
  double line_error_m = 0;  // mean Z of the middle by the straight line alone; NaN: unusable
  WallView view;            // by the appliance's converter with the new constants
};

struct PmdReport {
  std::string folder;
  Frames fitted = Frames::kAll;
  Frames judged = Frames::kAll;
  std::vector<WallRow> rows;
  double worst_relative = 0;  // |error| / z of the rows from 1.5 m on (all, if there are none)
};

// Reads the recordings once more and judges them with the frames that were not fitted to.
dataset::Loaded<PmdReport> make_report(const WallFolder& folder, Frames fitted,
                                       const PmdCalibration& calibration);

// Of walls that the others put elsewhere, without a line's end.
std::string wrong_walls_text(const std::vector<WrongWall>& walls);
std::string report_text(const PmdReport& report, const PmdCalibration& calibration);

}  // namespace stof::host
