#pragma once

#include <cstdint>

#include "dsp/stereo/match_params.h"
#include "dsp/stereo/search/semi_global.h"

// MatchParams in the units of the rows of costs that a search adds up.
namespace stof::dsp {

// The most that costs can be as a search hands them out (FoundRow of row_search.h).
std::int64_t largest_cost(const MatchParams& params) noexcept;

// True when block sums, or the energies of a search in them, need u32.
bool needs_wide_sums(const MatchParams& params) noexcept;

// Of scanline optimisation and ordered search, in block sums: Sum is u32 where needs_wide_sums().
template <typename Sum>
EdgePenalties<Sum> block_penalties(const MatchParams& params) noexcept;
template <typename Sum>
Sum block_occlusion(const MatchParams& params) noexcept;

// Of semi-global search: on the mixed cost as it is; on block sums times path_factor() over 65536,
// so that eight paths fit u16.
PathParams<std::uint8_t> mixed_path_params(const MatchParams& params) noexcept;
PathParams<std::uint16_t> block_path_params(const MatchParams& params) noexcept;
// Whether all paths of the mixed cost together fit u8.
bool fit_narrow_sums(const PathParams<std::uint8_t>& params) noexcept;
std::uint32_t path_factor(const MatchParams& params) noexcept;

}  // namespace stof::dsp
