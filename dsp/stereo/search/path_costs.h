#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/cost/sad.h"

// One direction of scanline and semi-global optimisation on rows of costs, laid out
// [column][candidate] as in cost/sad.h:
//
//   paths[x][i] = costs[x][i] + min(p[i], p[i - 1] + small, p[i + 1] + small, m + large[x]) - m
//
// with p the paths of the pixel before x and m their minimum; where there is no pixel before,
// paths[x] = costs[x]. Every sum saturates at kNoCost, so that a candidate outside the image stays
// outside; neighbours beyond the first and last lane count as kNoCost. Costs plus large must stay
// below kNoCost for every candidate inside, so that it stays inside; where costs plus twice large
// do, nothing inside saturates. Source: Hirschmueller 2008, eq. 13.
namespace stof::dsp {

// Along the row: before x is x - 1, from the right x + 1; large[x] belongs to x either way. costs,
// paths: large.size() * lanes elements, lanes a multiple of 16, at most 256; may be the same
// memory. Cost is u8, u16 or u32; small <= large[x].
template <typename Cost>
using PathsAlong = void(std::span<const Cost> costs, int lanes, Cost small,
                        std::span<const Cost> large, bool from_left,
                        std::span<Cost> paths) noexcept;

// Both ways along the row at once: faster than one after the other, since each pixel waits for its
// neighbour's minimum. No overlap. edge_penalties_along() (edge_penalties.h) gives both `large`.
template <typename Cost>
using PathsBothWays = void(std::span<const Cost> costs, int lanes, Cost small,
                           std::span<const Cost> large_from_left,
                           std::span<const Cost> large_from_right, std::span<Cost> from_left,
                           std::span<Cost> from_right) noexcept;

// From another row: before x is `before`'s column x - shift (shift -1, 0 or 1: down-left, down,
// down-right when rows come from the top). before: the paths of that row, overlapping nothing; with
// shift 0 it may be the same memory as paths.
template <typename Cost>
using PathsAcross = void(std::span<const Cost> costs, std::span<const Cost> before, int shift,
                         int lanes, Cost small, std::span<const Cost> large,
                         std::span<Cost> paths) noexcept;

// One direction along the row and one straight across rows.
template <typename Cost>
struct AxesRow {
  std::span<const Cost> costs;
  int lanes;
  Cost small;
  bool from_left;  // else from the right
  std::span<const Cost> large_along;
  std::span<const Cost> large_across;  // empty where there is no row before
};

// Both at once, and their sum: faster than one after the other. front: paths of the row before,
// which become this row's. sums = the two paths, plus `others` where these are not empty; u8 sums
// saturate, others wrap. others and sums may be the same memory, else no overlap.
template <typename Cost>
using PathsOfAxes = void(const AxesRow<Cost>& row, std::span<Cost> front,
                         std::span<const Cost> others, std::span<Cost> sums) noexcept;

STOF_KERNELS(PathsAlong, paths_along, Neon<std::uint8_t>, Avx2<std::uint16_t>, Neon<std::uint32_t>)
STOF_KERNELS(PathsBothWays, paths_both_ways, Avx2<std::uint8_t>, Avx2<std::uint16_t>,
             Neon<std::uint32_t>)
STOF_KERNELS(PathsAcross, paths_across, Avx2<std::uint8_t>, Avx2<std::uint16_t>,
             Neon<std::uint32_t>)
STOF_KERNELS(PathsOfAxes, paths_of_axes, Avx2<std::uint8_t>, Avx2<std::uint16_t>)

// Checks the sizes of paths_of_axes, for its variants.
template <typename Cost>
void check_axes(const AxesRow<Cost>& row, std::size_t front, std::size_t others,
                std::size_t sums) noexcept {
  STOF_CHECK(row.lanes >= kCostLanes && row.lanes <= 256 && row.lanes % kCostLanes == 0 &&
             row.costs.size() == row.large_along.size() * static_cast<std::size_t>(row.lanes));
  STOF_CHECK(row.large_across.empty() || row.large_across.size() == row.large_along.size());
  STOF_CHECK(front == row.costs.size() && sums == front && (others == 0 || others == front));
}

}  // namespace stof::dsp
