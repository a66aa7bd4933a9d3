#pragma once

#include "dsp/fusion/interval/intersect.h"

namespace stof::dsp {

// What each sensor says of a row of a map.
struct SensorIntervals {
  IntervalRow stereo;
  IntervalRow pmd;
};

}  // namespace stof::dsp
