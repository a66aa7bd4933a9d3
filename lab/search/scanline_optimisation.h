#pragma once

#include <cstdint>
#include <span>

#include "dsp/stereo/cost/sad.h"
#include "lab/dsp_names.h"

// Scanline optimisation of one row of costs, laid out [column][candidate] as in cost/sad.h: the
// candidates i_0 .. i_(n-1) of lowest energy
//
//   sum over x of costs[x][i_x]  +  sum over x > 0 of change(i_x - i_(x-1))
//
// with change 0, `small` for one candidate to either side and large[x] for more. All of these in
// the units of the costs; small <= large[x]. Exact while costs plus twice large stay below kNoCost;
// beyond that sums saturate (path_costs.h). Source: Scharstein & Szeliski 2002, section 4.3.
namespace stof::lab {

// `large` everywhere here: n + 1 elements, of edge_penalties_along() (edge_penalties.h).

// Preselection: leaves to each pixel only the candidates between the lowest and the highest winner
// of the kBandReach columns to either side, and `band` candidates beyond; the others become
// kNoCost. winners: those of winner.h, kNoWinner allowed. A pixel that would be left without any
// candidate keeps all of its own. band >= 0.
inline constexpr int kBandReach = 8;
template <typename Sum>
void keep_band(std::span<const std::int16_t> winners, int lanes, int band,
               std::span<Sum> costs) noexcept;

// False where no pixel prefers any of its candidates to another.
template <typename Sum>
bool any_preference(std::span<const Sum> costs, int lanes) noexcept;

// The row of lowest energy; of several the one whose last candidate is the smallest, then the one
// before it, and so on. kNoWinner for pixels without a candidate (the energy is then that of the
// parts between them), and for a whole row without any_preference(): a flat picture matches
// everywhere, which is no match.
// paths: scratch of costs' size, left as the paths from the left; no overlap.
template <typename Sum>
void scanline_winners(std::span<const Sum> costs, int lanes, Sum small, std::span<const Sum> large,
                      std::span<Sum> paths, std::span<std::int16_t> winners) noexcept;

// marginals[x][i] = the lowest energy of all rows that have candidate i at x, less a number that
// depends on x alone; kNoCost where there is none. A row of costs like any other: checks and
// subpixel fits work on it. paths: from scanline_winners(). No overlap.
template <typename Sum>
void scanline_marginals(std::span<const Sum> costs, int lanes, Sum small,
                        std::span<const Sum> large, std::span<const Sum> paths,
                        std::span<Sum> marginals) noexcept;

// The functions above exist for costs of u16 and u32.

}  // namespace stof::lab
