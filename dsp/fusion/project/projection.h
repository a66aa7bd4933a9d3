#pragma once

#include "dsp/calib/calibration.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/fusion/project/project.h"

// The parameters of the kernel project(), from a calibration.
namespace stof::dsp {

Projection projection_of(const Calibration& calibration) noexcept;

// Row y of a table for pictures of `width`.
RayRow ray_row(const RayTable& rays, int width, int y) noexcept;

}  // namespace stof::dsp
