#pragma once

#include <cstdint>

#include "dsp/stereo/row_checks.h"
#include "dsp/stereo/search/semi_global.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

// MatchParams in the units of the rows of costs that a search adds up.
namespace stof::lab {

// The most that two pixels can differ by.
int largest_difference(const MatchParams& params) noexcept;

// The most that costs can be as a search hands them out (FoundRow of row_checks.h).
std::int64_t largest_cost(const MatchParams& params) noexcept;

// Their scale, for distinctness.
CostScale cost_scale(const MatchParams& params) noexcept;

// True when block sums, or the energies of a search in them, need u32.
bool needs_wide_sums(const MatchParams& params) noexcept;

// For scanline optimisation and dynamic programming, in block sums: Sum is u32 where
// needs_wide_sums().
template <typename Sum>
EdgePenalties<Sum> block_penalties(const MatchParams& params) noexcept;
template <typename Sum>
Sum block_occlusion(const MatchParams& params) noexcept;

// For semi-global search on block sums times path_factor() over 65536, so that eight paths fit u16.
// For AD-Census: ad_census_path_params() (dsp/stereo/search/semi_global_search.h).
PathParams<std::uint16_t> block_path_params(const MatchParams& params) noexcept;
std::uint32_t path_factor(const MatchParams& params) noexcept;

}  // namespace stof::lab
