#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/sad.h"
#include "lab/dsp_names.h"

// Dynamic programming along one row of costs, laid out [column][candidate] as in cost/sad.h, with
// occlusions and the ordering constraint: of two matched left pixels the right one meets the
// farther right column, so that no two share one. Minimises exactly
//
//   costs of the matched pixels + occlusion for each left pixel without a match
//   + for each change of candidate: small for one, large[x] for more
//
// The states between one matched pixel and the next, at x:
//   match            the candidate stays
//   right occlusion  x is the next column and the candidate falls by k: k right columns are skipped
//   left occlusion   the candidate rises by k: k left pixels before x are without a match
// Left pixels before the first and after the last match are without one and change nothing.
// Source: Bobick & Intille 1999; Scharstein & Szeliski 2002, section 4.3.
namespace stof::lab {

// All in the units of the costs. Exact while lanes * occlusion plus twice large plus the largest
// cost stay below kNoCost; what lags farther behind is given up.
template <typename Sum>
struct DpPenalties {
  Sum small = 0;
  Sum occlusion = 0;
  std::span<const Sum> large;  // n + 1 elements, as in scanline_optimisation.h
};

// The memory of dp_winners(): the energies of one row. Those of a column are relative to the
// lowest of that column.
template <typename Sum>
struct DpTable {
  std::size_t lanes;
  std::span<Sum> matched;  // [x][i]: x is matched by i
  std::span<Sum> hidden;   // [x][i]: x is without a match, and a match by i may follow
  std::span<Sum> started;  // [x]: all left pixels before x are without a match, relative to x - 1
  std::span<Sum> base;     // [x]: what x - 1's reference rose by at x
  std::span<Sum> scratch;  // [i] twice

  // For rows of up to so many columns.
  DpTable(int columns, int lane_count, Arena& arena) noexcept
      : lanes(static_cast<std::size_t>(lane_count)) {
    const std::size_t n = static_cast<std::size_t>(columns);
    matched = arena.take<Sum>(n * lanes);
    hidden = arena.take<Sum>(n * lanes);
    started = arena.take<Sum>(n);
    base = arena.take<Sum>(n);
    scratch = arena.take<Sum>(2 * lanes);
  }
  Sum* matched_at(std::size_t x) const noexcept { return matched.data() + x * lanes; }
  Sum* hidden_at(std::size_t x) const noexcept { return hidden.data() + x * lanes; }
};

// winners: the candidates of lowest energy; kNoWinner for left pixels without a match, and for a
// whole row without any_preference() (scanline_optimisation.h). Costs of u16 or u32.
template <typename Sum>
void dp_winners(std::span<const Sum> costs, int lanes, const DpPenalties<Sum>& penalties,
                DpTable<Sum>& table, std::span<std::int16_t> winners) noexcept;

// Gives each run of pixels without a winner the smaller candidate of its two ends: only the
// background, the farther side, can continue behind an edge. Marks what was given: filled[x] 1,
// else 0. A row without any winner stays.
void extend_background(std::span<std::int16_t> winners, std::span<std::uint8_t> filled) noexcept;

}  // namespace stof::lab
