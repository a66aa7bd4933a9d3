#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/target.h"
#include "dsp/fusion/fuser.h"

namespace stof::dsp {

// Depth intervals of a row of the left view, quarter mm. A sensor says nothing about a pixel where
// max(low, 1) > min(high, max_range): so 0, 0 and kNothingPainted, 0 mean none, and what lies
// wholly beyond max_range counts as none.
struct IntervalRow {
  std::span<const QuarterMm> low;
  std::span<const QuarterMm> high;
};

// Both sensors' intervals to one depth (SPEC section 4). With every low at least 1 and every high
// at most max_range:
//   both, max(low) <= min(high)   the intersection, kBoth
//   one                           its interval, kStereo or kPmd
//   none                          depth 0, kNone
//   both, max(low) > min(high)    where pmd_flags has no kPmdEdge: the PMD interval, kResolved;
//                                 else depth 0, kConflict
// Why so: without kPmdEdge all readings around the pixel agree within their noise, so one surface
// is seen there and its place in the left view hardly matters. Their interval, the extremes of up
// to nine readings and 2 sigma more, then misses the surface far more rarely than block matching
// finds a wrong match, which may lie anywhere. At an edge the PMD is the coarser of the two and a
// wrong footprint is as likely as a wrong match: nobody is clearly better supported.
// For an interval [lo, hi]: depth = (lo + hi) / 2 rounded down, width = hi - lo rounded up to even,
// so that [depth - width / 2, depth + width / 2] holds it, is at most one longer, and fits u16.
// Width is 0 where depth is. max_range: quarter mm. Equal lengths, any alignment; no overlap.
using IntersectKernel = void(const IntervalRow& stereo, const IntervalRow& pmd,
                             std::span<const std::uint8_t> pmd_flags, QuarterMm max_range,
                             std::span<QuarterMm> depth, std::span<QuarterMm> width,
                             std::span<Source> source) noexcept;
namespace ref {
IntersectKernel intersect;
}
namespace neon {
IntersectKernel intersect;
}

}  // namespace stof::dsp
