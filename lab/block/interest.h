#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "lab/dsp_names.h"

// Interest operators on the horizontal derivative: only positions that stand out are matched, and
// only with positions of the other picture that stand out too. `derivative` is a row of
// clipped_sobel() with `cap` (prefilter.h); its size is |value - cap|, 0..cap. A mask has 1 at
// interesting positions, else 0. Source: Kuhnert & Stommel 2006, section 2.2.
namespace stof::lab {

// (a) Positions where the size of the derivative is at least `threshold` (1..cap) and a local
// maximum along the row: of a run of equal sizes whose neighbours are smaller, the middle one (the
// left of two).
void interest_maxima(std::span<const std::uint8_t> derivative, int cap, int threshold,
                     std::span<std::uint8_t> mask) noexcept;

// (b) Positions where the size is at least `threshold`. A higher one on the left, a lower one on
// the right picture: then every left position finds its partner although noise has made it weaker.
void interest_above(std::span<const std::uint8_t> derivative, int cap, int threshold,
                    std::span<std::uint8_t> mask) noexcept;

// Takes the cost from every candidate of a row (kNoCost) that is not a pair of interesting
// positions; then the winner, the left-right check and the rest see no others. costs: [column]
// [candidate] as in sad.h, left.size() columns; candidate i of column x meets right column
// x - min_disparity - i. Sizes of left and right are equal.
template <typename Sum>
void keep_interesting(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                      int min_disparity, int lanes, std::span<Sum> costs) noexcept;
extern template void keep_interesting(std::span<const std::uint8_t>, std::span<const std::uint8_t>,
                                      int, int, std::span<std::uint16_t>) noexcept;
extern template void keep_interesting(std::span<const std::uint8_t>, std::span<const std::uint8_t>,
                                      int, int, std::span<std::uint32_t>) noexcept;

// winners() of such a row: the lowest cost, the smallest candidate of a tie. Unlike winners() of
// search/winner.h it takes a candidate that has no rival: that it stands out has been seen already.
template <typename Sum>
void interesting_winners(std::span<const Sum> costs, int lanes,
                         std::span<std::int16_t> winners) noexcept;
extern template void interesting_winners(std::span<const std::uint16_t>, int,
                                         std::span<std::int16_t>) noexcept;
extern template void interesting_winners(std::span<const std::uint32_t>, int,
                                         std::span<std::int16_t>) noexcept;

}  // namespace stof::lab
