#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {

// A bit of the census counts twice as much as a grey level, and larger differences count as the
// cap: the structure of the surroundings decides, grey values and their derivative where it does
// not. The same for every scene; in the spirit of AD-Census (Mei et al. 2011).
inline constexpr int kAdCensusGreyCap = 24;
inline constexpr int kAdCensusDerivativeCap = 20;
inline constexpr int kLargestAdCensusCost =
    2 * kCensus7x7.bits() + (kAdCensusGreyCap + kAdCensusDerivativeCap) / 2;

// One row of one picture. The left one has n columns, the right one n + lanes - 1, reversed.
struct AdCensusRow {
  std::span<const std::uint8_t> planes;  // census 7x7 (census.h)
  std::span<const std::uint8_t> grey;
  std::span<const std::uint8_t> derivative;  // horizontal (prefilter.h), of any cap
};

// costs[k][i] = 2 hamming(left, right) + half of (min(|grey difference|, kAdCensusGreyCap) +
// min(|derivative difference|, kAdCensusDerivativeCap)), rounded down, of left column k and its
// candidate i, element n - 1 - k + i of the right row: the layout of sad.h. n at least 1, lanes a
// multiple of 16, any alignment, costs overlap nothing.
using AdCensusCosts = void(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                           std::span<std::uint8_t> costs) noexcept;
STOF_KERNEL(AdCensusCosts, ad_census_costs, kAvx2)

}  // namespace stof::dsp
