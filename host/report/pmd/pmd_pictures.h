#pragma once

#include <vector>

#include "host/evaluate/pmd/figures.h"
#include "host/report/page/page.h"

// PMD figures as maps and 2.5D views. Figures without data are left out.
namespace stof::host {

std::vector<Figure> mask_figures(const WallStudy& study);  // ratio and valid pixels of a far wall
std::vector<Figure> flat_wall_figures(const WallStudy& study);
std::vector<Figure> pattern_figures(const PmdCalibration& calibration);
Figure marks_figure(const EdgeStudy& study);  // mixed and flagged pixels
Figure height_field_figure(const EdgeStudy& study);
std::vector<Figure> cloud_figures(const FrameStudy& study);

}  // namespace stof::host
