#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {

// Larger grey differences count as this one, and two grey levels as much as one bit of the census:
// the structure of the surroundings decides, the grey value only between equals. The same for every
// scene; in the spirit of AD-Census (Mei et al. 2011).
inline constexpr int kAdCensusGreyCap = 6;
inline constexpr int kAdCensusGreyShift = 1;
inline constexpr int kLargestAdCensusCost =
    kCensus5x5Bits + (kAdCensusGreyCap >> kAdCensusGreyShift);

// One row of one picture. The left one has n columns, the right one n + lanes - 1, reversed.
struct AdCensusRow {
  std::span<const std::uint8_t> planes;  // census 5x5 (census.h)
  std::span<const std::uint8_t> grey;
};

// costs[k][i] = hamming(left, right) + (min(|grey difference|, kAdCensusGreyCap) >>
// kAdCensusGreyShift) of left column k and its candidate i, element n - 1 - k + i of the right row:
// the layout of sad.h. n at least 1, lanes a multiple of 16, any alignment, costs overlap nothing.
using AdCensusCosts = void(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                           std::span<std::uint8_t> costs) noexcept;
STOF_KERNEL(AdCensusCosts, ad_census_costs, kAvx2)

}  // namespace stof::dsp
