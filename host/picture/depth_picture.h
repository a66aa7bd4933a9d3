#pragma once

#include "dsp/base/fixed.h"
#include "host/picture/colour_scale.h"

namespace stof::host {

// A depth map in the colours of the scale, with the scale and its distances drawn beside it
// (legend.h). Pixels without depth are a dark grey checker.
dataset::Image<Rgb> depth_picture(const dataset::Image<dsp::QuarterMm>& depth,
                                  const ColourScale& scale);

}  // namespace stof::host
