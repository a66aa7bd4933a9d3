#pragma once

#include <string>
#include <vector>

#include "host/calibrate/rig/check/rig_check.h"
#include "host/calibrate/rig/extrinsics/extrinsic_fit.h"
#include "host/calibrate/rig/extrinsics/pmd_board_views.h"
#include "host/calibrate/rig/planes/plane_judgement.h"
#include "host/calibrate/rig/target/target_calibration.h"

// What calibrations of a rig came to, as text for people.
namespace stof::host {

// What speaks against a calibration that is not refused, a line each.
std::vector<std::string> notes_of(const TargetCalibration& found);

std::string target_text(const TargetCalibration& found);
std::string planes_text(const PlaneCalibration& found);
std::string extrinsics_text(const ExtrinsicFit& fit, const FoundWalls& found);
std::string board_extrinsics_text(const ExtrinsicFit& fit, const PmdBoardViews& found);
std::string check_text(const RigCheck& check);

// Residuals of every view as one self-contained HTML page with inline SVG.
std::expected<void, dataset::Problem> write_target_page(const TargetCalibration& found,
                                                        const std::filesystem::path& file);

}  // namespace stof::host
