#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/depth_map.h"

namespace stof::dsp {

// Depth intervals of a row of the left view, quarter mm. A sensor says nothing about a pixel where
// max(low, 1) > min(high, max_range): so 0, 0 and kNoSplat, 0 mean none, and what lies
// wholly beyond max_range counts as none.
struct IntervalRow {
  std::span<const QuarterMm> low;
  std::span<const QuarterMm> high;
};

// What speaks for or against each sensor's interval.
struct SupportRow {
  std::span<const std::uint8_t> ratio;      // peak ratio of the match (validation/peak_ratio.h)
  std::span<const std::uint8_t> pmd_flags;  // PmdFlag of all footprints that cover the pixel
};

// A match is sure where its best rival costs five thirds of it or more. Of such matches 94 to 100
// percent are right on every scene measured, of the others as few as a third.
inline constexpr std::uint8_t kSureRatio = 154;

// What a pixel became.
struct FusedRow {
  std::span<QuarterMm> depth;
  std::span<QuarterMm> width;
  std::span<Source> source;
  std::span<Cause> cause;
};

// Both sensors' intervals to one depth. With every low at least 1 and every high
// at most max_range:
//   both, max(low) <= min(high)   the intersection, kBoth
//   one                           its interval, kStereo or kPmd
//   none                          depth 0, kNone
//   both, max(low) > min(high)    by what supports them:
//                      sure match (ratio < kSureRatio)         match with rivals
//     no kPmdEdge      depth 0, kConflict, kContradiction      PMD, kResolved, kStereoAmbiguous
//     kPmdEdge         stereo, kResolved, kMixedPixel          depth 0, kConflict, kMixedPixel
// Why so: without kPmdEdge all readings around the pixel agree within their noise, so one surface
// is seen there; a match with rivals may lie anywhere. At an edge the PMD reading is a mixture,
// while a match without rivals is a point. Where both are sound something is wrong that neither can
// know of. cause is kNone where there was no disagreement. For an interval [lo, hi]: depth = (lo +
// hi) / 2 rounded down, width = hi - lo rounded up to even, so that [depth - width / 2, depth +
// width / 2] holds it, is at most one longer, and fits u16. Width is 0 where depth is. max_range:
// quarter mm. Equal lengths, any alignment; no overlap.
using IntersectKernel = void(const IntervalRow& stereo, const IntervalRow& pmd,
                             const SupportRow& support, QuarterMm max_range,
                             const FusedRow& out) noexcept;
STOF_KERNEL(IntersectKernel, intersect, kAvx2)

// depth and width of an interval that is not empty, as above.
constexpr QuarterMm middle_of(int low, int high) noexcept {
  return static_cast<QuarterMm>((low + high) / 2);
}
constexpr QuarterMm width_of(int low, int high) noexcept {
  return static_cast<QuarterMm>((high - low + 1) / 2 * 2);
}

}  // namespace stof::dsp
