#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"

// How much better than its rivals a winner is, from the costs of all candidates.
namespace stof::dsp {

// The peak ratio of each pixel: ratio[x] = floor(255 c / r), c the cost of winners[x], r that of
// its best rival (a candidate other than i - 1, i, i + 1 with a cost); 0 = nothing else comes near,
// 255 = a rival is as good. 255 too where there is no rival (nothing was compared), no winner, or
// where the winner has no cost; c > r counts as c = r. Source: the "peak ratio, naive" of Hu &
// Mordohai, A Quantitative Evaluation of Confidence Measures for Stereo Vision, PAMI 2012,
// inverted. One IEEE single quotient: 255 c rounded to single, over r rounded to single, cut off.
// numbered: whether costs are numbered_cost() each (search/block_winners.h), which u16 alone can
// be. Layout as in cost/sad.h; lanes a multiple of 16, at most 256.
template <typename Sum>
using PeakRatio = void(std::span<const Sum> costs, int lanes, bool numbered,
                       std::span<const std::int16_t> winners,
                       std::span<std::uint8_t> ratio) noexcept;

inline constexpr std::uint8_t kRatioOfTie = 255;

STOF_KERNELS(PeakRatio, peak_ratio, Avx2<std::uint8_t>, Avx512<std::uint16_t>, Neon<std::uint32_t>)

}  // namespace stof::dsp
