#pragma once

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/interval/column_interval.h"
#include "dsp/fusion/interval/stereo_interval.h"

namespace stof::dsp {

// Tables from disparities to depth intervals: by both columns where the axes converge, else by the
// disparity alone.
struct IntervalTables {
  bool converging = false;
  ColumnTables columns;      // where converging
  DisparityTable disparity;  // where not
};

// For all subpixel disparities of a matcher's candidates and half a candidate to either side, in
// rows of `width` pixels. max_range in quarter mm.
IntervalTables make_interval_tables(const StereoRig& rig, int min_disparity, int disparities,
                                    int width, QuarterMm max_range, Arena& arena) noexcept;

}  // namespace stof::dsp
