#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {

enum class CostFit : std::uint8_t { kNone, kEquiangular, kParabola };

// out[x] = (min_disparity + winners[x]) * 16 + s, none where there is no winner. s, in -8..8 (1/16
// px), is a fit of the costs around the winner i, s = (c[i-1] - c[i+1]) / (2 r), rounded to the
// nearest, halves away from 0; 0 where a neighbour is missing, r is 0, or a neighbour costs less
// (then the winner is not a minimum of these costs). The fits differ in r:
//   kEquiangular  r = max(c[i-1], c[i+1]) - c[i]: two lines of equal slope, for absolute
//                 differences (Shimizu & Okutomi 2005)
//   kParabola     r = c[i-1] + c[i+1] - 2 c[i]: for squared differences
//   kNone         s = 0; costs may be empty
// costs as in sad.h; u32 sums below 2^27. |min_disparity| + lanes <= 2047.
template <typename Sum>
using RefineWinners = void(std::span<const Sum> costs, int lanes, CostFit fit, int min_disparity,
                           std::span<const std::int16_t> winners,
                           std::span<Disparity> out) noexcept;

STOF_KERNELS(RefineWinners, refine_winners, Neon<std::uint16_t>, Neon<std::uint32_t>)

}  // namespace stof::dsp
