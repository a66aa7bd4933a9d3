#pragma once

#include <cstddef>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// What drop_speckles takes from its Arena: 4 bytes a pixel and some rows.
std::size_t drop_speckles_bytes(int width, int height) noexcept;

// Drops connected patches of fewer than min_pixels pixels. Two pixels are connected when they share
// a side and their disparities differ by at most 1 px; a patch may span more. Time does not depend
// on the patches' shapes or sizes; no recursion.
void drop_speckles(ImageView<Disparity> disparities, int min_pixels, Arena arena) noexcept;

}  // namespace stof::dsp
