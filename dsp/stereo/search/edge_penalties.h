#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"

// Penalties for a change of disparity at an edge of grey values: less, because surfaces end there.
// Cost is u8, u16 or u32.
namespace stof::dsp {

// The penalty for a large change: all of it where both pixels look alike, half where their grey
// values differ by more than `edge`, a quarter by more than `strong_edge`; never less than `small`.
template <typename Cost>
struct EdgePenalties {
  Cost small = 0;
  Cost large = 0;
  int edge = 16;  // grey levels
  int strong_edge = 32;
};

// large[x] between here[x] and before[x]: written so that compilers see vectors.
template <typename Cost>
void penalties_between(std::span<const std::uint8_t> here, std::span<const std::uint8_t> before,
                       const EdgePenalties<Cost>& p, std::span<Cost> large) noexcept {
  const Cost flat = std::max(p.small, p.large);
  const Cost weak = std::max(p.small, static_cast<Cost>(p.large / 2));
  const Cost strong = std::max(p.small, static_cast<Cost>(p.large / 4));
  const auto edge = static_cast<std::uint8_t>(std::clamp(p.edge, 0, 255));
  const auto strong_edge = static_cast<std::uint8_t>(std::clamp(p.strong_edge, 0, 255));
  for (std::size_t x = 0; x < here.size(); ++x) {
    const auto difference =
        static_cast<std::uint8_t>(std::max(here[x], before[x]) - std::min(here[x], before[x]));
    const Cost below = difference > edge ? weak : flat;
    large[x] = difference > strong_edge ? strong : below;
  }
}

// Along one row of grey values: n + 1 elements, large[x] between the columns x - 1 and x; the first
// and the last count for nothing. So large.first(n) is what paths_along (path_costs.h) takes from
// the left and large.subspan(1) what it takes from the right.
template <typename Cost>
void edge_penalties_along(std::span<const std::uint8_t> row, const EdgePenalties<Cost>& penalties,
                          std::span<Cost> large) noexcept {
  STOF_CHECK(large.size() == row.size() + 1);
  std::ranges::fill(large, penalties.large);
  if (row.size() > 1) {
    penalties_between(row.subspan(1), row.first(row.size() - 1), penalties, large.subspan(1));
  }
}

// Between two rows: here[x] and before[x - shift], shift -1, 0 or 1, as in paths_across; n
// elements. Where before has no such column, all of the penalty.
template <typename Cost>
void edge_penalties_across(std::span<const std::uint8_t> here, std::span<const std::uint8_t> before,
                           int shift, const EdgePenalties<Cost>& penalties,
                           std::span<Cost> large) noexcept {
  STOF_CHECK(here.size() == before.size() && large.size() == here.size() && shift >= -1 &&
             shift <= 1);
  std::ranges::fill(large, penalties.large);
  const std::size_t begin = shift > 0 ? 1U : 0U;  // the first column with one before it
  const std::size_t from = shift < 0 ? 1U : 0U;
  if (here.size() > begin + from || shift == 0) {
    const std::size_t n = here.size() - begin - from;
    penalties_between(here.subspan(begin, n), before.subspan(from, n), penalties,
                      large.subspan(begin));
  }
}

}  // namespace stof::dsp
