#pragma once

#include <string>

#include "host/calibrate/report/pmd_report.h"

namespace stof::host {

// A calibration and its report, for programs.
std::string report_json(const PmdReport& report, const PmdCalibration& calibration);

}  // namespace stof::host
