#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// A window of samples: kWindow by kWindow of them, around a place.
inline constexpr int kWindow = 4;
// Columns and rows of samples without depth on every side of a grid.
inline constexpr int kGridBorder = kWindow;

// Stereo's depth intervals at every step-th column and row of the left view, quarter mm:
// low <= high, 65535 stands for all that lies beyond. No depth: low 65535, high 0. Sample (i, j)
// stands for pixel (i * step + step / 2, j * step + step / 2).
struct SampleGrid {
  const QuarterMm* low = nullptr;  // sample (0, 0)
  const QuarterMm* high = nullptr;
  std::ptrdiff_t stride = 0;  // elements of a row; at least columns + 2 kGridBorder
  int columns = 0;
  int rows = 0;
  int step_bits = 0;  // step = 1 << step_bits
};

// How many samples of a window have a depth, agree with a reading, lie far off it; each 0 .. 16.
struct Votes {
  std::uint16_t packed = 0;
  static constexpr int kField = 32;  // of 5 bits each
  constexpr int known() const noexcept { return packed % kField; }
  constexpr int agree() const noexcept { return packed / kField % kField; }
  constexpr int apart() const noexcept { return packed / (kField * kField); }
  friend constexpr bool operator==(Votes, Votes) noexcept = default;
};
static_assert(sizeof(Votes) == sizeof(std::uint16_t));

// For a row of readings that lie at (u, v) in the left view (1/16 px, kFarthestPosition at most)
// with depth +- tolerance, the window of samples whose middle is nearest to the place:
//   known   high is not 0
//   agree   low <= depth + tolerance and high >= max(depth - tolerance, 1)
//   apart   known, and low > depth + far_off or high < depth - far_off; sums saturate
// A place outside of the grid finds what is inside of its window. depth 0: no votes. Equal lengths,
// any length, any alignment; no overlap.
struct Places {
  std::span<const std::int32_t> u;
  std::span<const std::int32_t> v;
  std::span<const QuarterMm> depth;
  std::span<const QuarterMm> tolerance;
};
using CountVotes = void(const Places& places, const SampleGrid& grid, QuarterMm far_off,
                        std::span<Votes> votes) noexcept;
STOF_KERNEL(CountVotes, count_votes, kAvx2)

}  // namespace stof::dsp
