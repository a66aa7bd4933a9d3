#pragma once

#include "host/evaluate/pmd/figures.h"

namespace stof::host {

// The figures of PMD recordings as one self-contained HTML page, with pictures made from them that
// stand for those of Kuhnert & Stommel 2006, section 3. One line when it cannot be written.
std::expected<void, dataset::Problem> write_pmd_page(const PmdEvaluation& evaluation,
                                                     const std::filesystem::path& file);

// The results and the quality of a calibration, as such a page.
std::expected<void, dataset::Problem> write_calibration_page(const PmdReport& report,
                                                             const PmdCalibration& calibration,
                                                             const std::filesystem::path& file);

}  // namespace stof::host
