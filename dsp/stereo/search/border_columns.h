#pragma once

#include <cstdint>
#include <span>

#include "dsp/stereo/cost/candidate_mask.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {

// The columns at either end of the range meet the right picture with one candidate only and have no
// rival to judge it by: they take it where the next column found a match. winners: of one row, as
// in winner.h. min_disparity in px; disparities: candidates, at least 1.
void match_border_columns(int min_disparity, int disparities,
                          std::span<std::int16_t> winners) noexcept;

// The same where a guide (cost/candidate_mask.h) may leave out candidates: what it leaves out is
// none, before and after. An empty one leaves out nothing.
void finish_winners(const MatchParams& params, GuideRow guide,
                    std::span<std::int16_t> winners) noexcept;

}  // namespace stof::dsp
