#pragma once

#include "host/evaluate/pmd/figures.h"
#include "host/report/page/page.h"

// Pictures of PMD figures. What a study has no data for is left out.
namespace stof::host {

// Lines and points over two axes.
std::vector<Figure> noise_figures(const WallStudy& study);        // sigma over distance
std::vector<Figure> calibration_figures(const WallStudy& study);  // line, residual
std::vector<Figure> ratio_figures(const WallStudy& study);        // amplitude and ratio
std::vector<Figure> stray_figures(const WallStudy& study);
std::vector<Figure> light_figures(const LightStudy& study);
Figure section_figure(const EdgeStudy& study, int around_px);  // that many px around the edge

// Maps and views.
std::vector<Figure> mask_figures(const WallStudy& study);  // ratio and valid pixels of a far wall
std::vector<Figure> flat_wall_figures(const WallStudy& study);
Figure marks_figure(const EdgeStudy& study);  // mixed and flagged pixels
Figure relief_figure(const EdgeStudy& study);
std::vector<Figure> cloud_figures(const FrameStudy& study);

}  // namespace stof::host
