#pragma once

#include <cstdint>
#include <span>

namespace stof::dsp {

// The columns at either end of the range meet the right picture with one candidate only and have no
// rival to judge it by: they take it where the next column found a match. winners: of one row, as
// in winner.h. min_disparity in px; disparities: candidates, at least 1.
void settle_single_candidates(int min_disparity, int disparities,
                              std::span<std::int16_t> winners) noexcept;

}  // namespace stof::dsp
