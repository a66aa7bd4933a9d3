#pragma once

#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "lab/dsp_names.h"

namespace stof::lab {

// A pixel without a disparity takes the smaller (farther) of the nearest valid ones to its left and
// right: what only one camera sees belongs to the background. At the ends of a row there is one
// neighbour only; a row without any valid disparity stays none. filled becomes 1 where a value is
// made up and stays as it is elsewhere. Equal sizes.
void fill_from_background(ImageView<Disparity> disparities, Rows rows,
                          ImageView<std::uint8_t> filled) noexcept;

}  // namespace stof::lab
