#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Three neighbouring rows of distance and sigma. For a row of n pixels each span has n + 2
// elements: element x + 1 belongs to pixel x; the first and the last are the neighbours outside the
// row, 0 at the border of the image. At the upper and lower border `above` or `below` repeats
// `here`. A missing reading has distance and sigma 0.
struct IntervalRows {
  std::span<const QuarterMm> distance_above;
  std::span<const QuarterMm> distance_here;
  std::span<const QuarterMm> distance_below;
  std::span<const QuarterMm> sigma_above;
  std::span<const QuarterMm> sigma_here;
  std::span<const QuarterMm> sigma_below;
};

// The same from pixel x on.
inline IntervalRows behind(const IntervalRows& rows, std::size_t x) noexcept {
  return {rows.distance_above.subspan(x), rows.distance_here.subspan(x),
          rows.distance_below.subspan(x), rows.sigma_above.subspan(x),
          rows.sigma_here.subspan(x),     rows.sigma_below.subspan(x)};
}

// All quarter mm.
struct IntervalLimits {
  QuarterMm range = kMaxQuarterMm;   // unambiguous range: what readings repeat after
  QuarterMm widest = kMaxQuarterMm;  // half of one turn: see below
  // What a slanted surface gains over two pixels, as a share of its distance, Q16: not an edge.
  std::uint16_t slope_q16 = 0;
};

// The interval that holds the surface seen by a pixel, for one row: nearest and farthest valid
// reading (distance not 0) of the 3x3 neighbourhood, nearest - 2 sigma(nearest) and
// farthest + 2 sigma(farthest), saturating. Of equal distances the nearest takes the smallest
// sigma, the farthest the largest. Where the pixel itself is missing: low = high = 0.
// Source: Kuhnert & Stommel 2006 section 4.1; a mixed reading lies between its surfaces if these
// are less than half a turn apart. Bits added to flags:
//   kPmdWrapped     high - low is above widest, or 2 sigma reach below 0, so that the reading
//                   may as well be one of nearly the whole range; then low = high = 0
//   kPmdEdge        nearest and farthest differ by more than 3 (sigma + sigma) + ((nearest
//                   slope_q16) >> 16): more than noise and the slope of a surface
//   kPmdOutOfRange  high is above range, the pixel's own reading is not: the far end is more than
//                   this sensor can tell. Or high is 65535, which is more than it can say. A
//                   reading above range is one that was moved by whole ranges, by who knew better
// Any length, any alignment; no overlap.
using IntervalKernel = void(const IntervalRows& rows, const IntervalLimits& limits,
                            std::span<std::uint8_t> flags, std::span<QuarterMm> low,
                            std::span<QuarterMm> high) noexcept;
STOF_KERNEL(IntervalKernel, interval, kNeon)

}  // namespace stof::dsp
