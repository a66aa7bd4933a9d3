#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/interval/stereo_interval.h"

namespace stof::dsp {

// The table of disparities first_raw, first_raw + 1, ... that fills `bounds`, which it refers to:
// Z = f b / (d + doff) of each, rounded outwards. max_range in quarter mm.
DisparityTable make_disparity_table(const StereoRig& rig, std::int16_t first_raw,
                                    QuarterMm max_range, std::span<DepthInterval> bounds) noexcept;

}  // namespace stof::dsp
