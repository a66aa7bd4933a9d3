#pragma once

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// out = the median of the valid disparities among a pixel and its eight neighbours; of an even
// count the lower of the two in the middle. A pixel that is none stays none; neighbours outside the
// image count as none. Writes `rows` of out, reads one more to either side of in; equal sizes, any
// strides, no overlap. Any split of rows gives the same.
using MedianDisparity = void(ImageView<const Disparity> in, Rows rows,
                             ImageView<Disparity> out) noexcept;
STOF_KERNEL(MedianDisparity, median_disparity, kNeon)

// Columns [begin, end) of row y, for the ends of vector variants.
void median_disparity_columns(ImageView<const Disparity> in, int y, int begin, int end,
                              ImageView<Disparity> out) noexcept;

}  // namespace stof::dsp
