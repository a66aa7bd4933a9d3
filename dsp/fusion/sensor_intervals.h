#pragma once

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// What each sensor said of a frame, in the axes and size of its map: rows as IntervalRow has them.
struct SensorIntervals {
  ImageView<const QuarterMm> stereo_low;
  ImageView<const QuarterMm> stereo_high;
  ImageView<const QuarterMm> pmd_low;
  ImageView<const QuarterMm> pmd_high;
};

}  // namespace stof::dsp
