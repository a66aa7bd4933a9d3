#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/stereo_interval.h"

namespace stof::dsp {

// Depth interval of each raw disparity first_raw + i, i = 0 .. size - 2, and none at the end:
// [Z(d + 2 sigma), Z(d - 2 sigma)], Z = f b / (d + doff), rounded outwards, at least 1. A far end
// beyond max_range, at infinity or behind it is max_range; where the near end is there too: none.
// sigma_raw in 1/16 px, not negative.
void fill_disparity_table(const StereoRig& rig, std::int16_t first_raw, std::int16_t sigma_raw,
                          QuarterMm max_range, std::span<DepthInterval> intervals) noexcept;

}  // namespace stof::dsp
