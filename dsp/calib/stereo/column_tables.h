#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/interval/column_interval.h"

namespace stof::dsp {

// Rays further than 75 degrees from the perpendicular of the baseline are not used.
inline constexpr double kSteepestRad = 1.3089969389957472;

// T of a column of the left or right picture: how far left of the perpendicular of the baseline its
// ray runs, per unit of Z. Rectified: -(x - cx) / fx; converging: tan(yaw + atan(-(x - cx) u / f)).
// NaN beyond 75 degrees. The rig is complete().
double left_tangent(const StereoRig& rig, double x) noexcept;
double right_tangent(const StereoRig& rig, double x) noexcept;

// Z in metres of disparity d px at column x of the left picture, baseline / (T_r[x - d] - T_l[x]);
// infinite where the rays do not meet in front of the cameras, NaN where one of them is not used.
double depth_of(const StereoRig& rig, double x, double d) noexcept;

// Fills `left`, one element a column, and `right` (right_tangents() elements), and returns tables
// that refer to both. Disparities in 1/16 px; baseline_m 1 mm .. 1
// km.
ColumnTables make_column_tables(const StereoRig& rig, std::int16_t first_raw, std::int16_t last_raw,
                                QuarterMm max_range, std::span<std::int32_t> left,
                                std::span<std::int32_t> right) noexcept;

}  // namespace stof::dsp
