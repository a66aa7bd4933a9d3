#pragma once

#include <vector>

#include "host/evaluate/pmd/figures.h"
#include "host/report/page/page.h"

// PMD figures as lines and points over two axes. Figures without data are left out.
namespace stof::host {

// Sigma over distance.
std::vector<Figure> noise_figures(const PmdReport& report, const PmdCalibration& calibration);
// Line, residual.
std::vector<Figure> calibration_figures(const PmdReport& report, const PmdCalibration& calibration);
std::vector<Figure> wiggling_figures(const PmdCalibration& calibration);
std::vector<Figure> ratio_figures(const WallStudy& study);  // amplitude and ratio
std::vector<Figure> stray_figures(const WallStudy& study);
std::vector<Figure> light_figures(const LightStudy& study);
Figure section_figure(const EdgeStudy& study, int around_px);  // that many px around the edge

}  // namespace stof::host
