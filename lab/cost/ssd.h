#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/sad.h"
#include "lab/cost/cost_sums.h"

// Sums of squared differences: sad.h's layout, sums and bounds, with (L - R)^2, at most 65025, in
// place of |L - R|. u32 holds every block (64 * 64 * 65025 = 266,342,400); u16 those that
// sums_fit_u16() allows, such as 8 x 9 for derivatives clipped at 15. Block sums: block_sums().
namespace stof::dsp {

// columns[k][i] += (left[k] - right[n - 1 - k + i])^2.
// columns[k][i] += (new_left[k] - new_right[..])^2 - (old_left[k] - old_right[..])^2.
STOF_KERNELS(AddDifferences, add_squares, Neon<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(SlideDifferences, slide_squares, Neon<std::uint16_t>, Neon<std::uint32_t>)

static_assert(sums_fit_u16(8, 9, 30 * 30) && !sums_fit_u16(9, 9, 30 * 30));

}  // namespace stof::dsp
