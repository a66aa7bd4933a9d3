#pragma once

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "lab/dsp_names.h"

namespace stof::lab {

// out = the median of the valid disparities in the 5x5 px around each pixel, of which those count
// more whose grey values are like its own: exp(-|difference| / 16). Edges of the map move to edges
// of the picture. A pixel that is none stays none, and one whose surroundings differ by less than a
// pixel stays as it is. Equal sizes, no overlap. Source: Ma, He, Wei, Sun & Wu 2013 (constant time
// weighted median filtering for stereo matching), whose weights need a colour picture.
void weighted_median(ImageView<const std::uint8_t> grey, ImageView<const Disparity> in,
                     ImageView<Disparity> out) noexcept;

}  // namespace stof::lab
