#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/pmd/interval/interval.h"

namespace stof::dsp {

// Readings and neighbours with a larger sigma are not averaged.
inline constexpr QuarterMm kMaxAveragedSigma = 2047;
// Farthest that a pair may pull a reading, quarter mm.
inline constexpr QuarterMm kMaxPull = 2047;

// Sigma of a mean of 1 + 2 p readings as a share of the mean sigma, Q15, by the number of pairs p:
// 1.4 / sqrt(1 + 2 p). Without the 1.4, 95 percent of the means lay within 2.1 to 2.3 sigma of the
// truth on ten recorded scenes, in place of 2; clutter asks for more.
inline constexpr std::array<std::uint16_t, 5> kSmoothShare{32768, 26486, 20516, 17339, 15292};
// 2 / (1 + 2 p), Q15: of the sum of what pairs differ by.
inline constexpr std::array<std::uint16_t, 5> kPairShare{0, 21845, 13107, 9362, 7282};

// Edge-preserving mean of the 3x3 neighbourhood, for one row. A pair are two neighbours opposite
// each other, (x - i, y - j) and (x + i, y + j): their mean lies on any plane through the reading,
// so that slopes stay. With distances a, b and sigmas s_a, s_b of a pair, d and s of the reading,
//   mean = (a + b + 1) / 2, noise = (s_a + s_b + 1) / 2,
// a pair counts where both are there, all three sigmas are at most kMaxAveragedSigma, and
//   |mean - d| <= min(2 s + noise, kMaxPull)   and   |a - b| <= 6 noise + slope,
// slope = (d slope_q16) >> 16. Over the p pairs that count:
//   out_distance = d + round(sum (mean - d) 2 / (1 + 2 p))
//   out_sigma    = max(min(s, round((s + 2 sum noise) / (1 + 2 p) kSmoothShare[p])), 1)
// each by the Q15 shares above, rounded to nearest; without a pair the reading stays as it is. A
// missing reading (distance 0) stays missing, 0, 0. Equal lengths n, rows as in IntervalRows; any
// length, any alignment; no overlap.
using AveragePairs = void(const IntervalRows& rows, std::uint16_t slope_q16,
                          std::span<QuarterMm> out_distance,
                          std::span<QuarterMm> out_sigma) noexcept;
STOF_KERNEL(AveragePairs, average_pairs, kNeon)

}  // namespace stof::dsp
