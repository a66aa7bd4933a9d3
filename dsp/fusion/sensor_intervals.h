#pragma once

#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/interval/late_intervals.h"

namespace stof::dsp {

// What each sensor says of a row of a map.
struct SensorIntervals {
  IntervalRow stereo;  // filled by `late` ..
  IntervalRow pmd;
  LateIntervals* late = nullptr;  // .. where somebody asks it, if it is there
};

}  // namespace stof::dsp
