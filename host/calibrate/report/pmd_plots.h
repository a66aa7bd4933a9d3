#pragma once

#include <expected>
#include <filesystem>

#include "host/calibrate/report/pmd_report.h"

namespace stof::host {

// residual.png, wiggling.png, sigma.png and, where there is one, pattern.png into a folder that
// exists.
std::expected<void, dataset::Problem> write_plots(const std::filesystem::path& folder,
                                                  const PmdReport& report,
                                                  const PmdCalibration& calibration);

}  // namespace stof::host
