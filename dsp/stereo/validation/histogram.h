#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// Drops every disparity whose share of the image is rare: rounded to whole pixels (halves up), it
// must occur in at least permille / 1000 of all width * height pixels. permille in 0..1000; a few
// thousandths tell outliers from surfaces. counts: scratch, disparities + 1 elements for valid
// disparities in [min_disparity, min_disparity + disparities - 1] +-1/2 px, which i16 holds; others
// count at the nearest end. Source: Kuhnert & Stommel 2006, section 2.3.
void drop_rare(ImageView<Disparity> disparities, int min_disparity, int permille,
               std::span<std::uint32_t> counts) noexcept;

}  // namespace stof::dsp
