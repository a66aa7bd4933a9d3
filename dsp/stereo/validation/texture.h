#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/stereo/validation/window_sums.h"

// The stability mask: a flat surface gives no disparity. Source: Kuhnert & Stommel 2006, 2.3.
namespace stof::dsp {

// Drops the disparities of `rows` where the mean |derivative| of the surroundings (24 x 24 px,
// window_sums.h) is below min_texture grey levels. derivative: clipped_sobel() of the left image
// with `cap` (prefilter.h), so the mean is at most cap; a cap of 15 is what presets are tuned for.
// This alone finds what is as flat as the camera's rounding: noise of 2 grey levels has a mean of 5
// to 6, as much as a tenth of a real picture. winner_margin.h finds matches of noise.
// Only `rows` of disparities are written; any split gives the same. window: scratch.
void drop_flat(ImageView<const std::uint8_t> derivative, int cap, int min_texture, Rows rows,
               WindowSums& window, ImageView<Disparity> disparities) noexcept;

}  // namespace stof::dsp
