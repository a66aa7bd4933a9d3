#pragma once

#include "dsp/calib/calibration.h"
#include "dsp/pmd/phase.h"
#include "dsp/pmd/range.h"

namespace stof::dsp {

// What the kernels of dsp/pmd need to know about a sensor, rounded once at start.
// All take a sensor that problem() accepts.
PhaseLimits phase_limits(const PmdSensor& sensor) noexcept;
RangeParams range_params(const PmdSensor& sensor) noexcept;

}  // namespace stof::dsp
