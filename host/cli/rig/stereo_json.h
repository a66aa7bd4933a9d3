#pragma once

#include <nlohmann/json.hpp>

#include "host/calibrate/rig/planes/plane_judgement.h"
#include "host/calibrate/rig/target/target_calibration.h"
#include "host/cli/rig/calib_rig.h"

// What `stof calib stereo --json` prints: docs/TOOL.md.
namespace stof::host {

// Of a board, with what speaks against it in words. `folder`: that held the views, or that they
// were kept in.
nlohmann::ordered_json target_json(const CalibStereoOptions& options,
                                   const std::filesystem::path& folder,
                                   const TargetCalibration& found);

// Of walls.
nlohmann::ordered_json planes_json(const CalibStereoOptions& options,
                                   const PlaneCalibration& found);

// A square matrix as an array of its rows.
nlohmann::ordered_json matrix_json(const Eigen::MatrixXd& matrix);

}  // namespace stof::host
