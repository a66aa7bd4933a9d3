#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"

namespace stof::dsp {

// What decides how a pixel of a fused row is resolved.
struct MaskRow {
  std::span<const Disparity> disparity;
  std::span<const Disparity> weak;  // or empty
  SupportRow support;
  IntervalRow stereo;
  IntervalRow pmd;
  std::span<const Source> source;
  std::span<const Cause> cause;
  QuarterMm max_range = kMaxQuarterMm;
  QuarterMm pmd_range = 0;  // unambiguous range of the PMD; 0 = not to be considered
};

// One bit for each pixel, 64 a word, the first lowest; bits behind the last pixel are 0.
//   open      kPmd with (high - low) kNarrowShare > low, or kConflict by kMixedPixel
//   matched   kStereo, kBoth or kResolved by kMixedPixel, with a disparity and a peak ratio below
//             kNeighbourRatio
//   folded    kConflict whose intervals, low at least 1 and high at most max_range, meet once the
//             PMD's is moved by one pmd_range, or up to a sixteenth less, to either side
//   weak      a weak match, and no disparity
//   edge      kPmdEdge
//   alone     kStereo, or kResolved by kMixedPixel: the match and nothing else
//   vague     kBoth with a disparity and a peak ratio of kVaguestRatio or more, or of kVagueRatio
//             where kPmdEdge
//   unsure    kResolved by kStereoAmbiguous: the PMD against a match
struct PixelMasks {
  std::span<std::uint64_t> open;
  std::span<std::uint64_t> matched;
  std::span<std::uint64_t> folded;
  std::span<std::uint64_t> weak;
  std::span<std::uint64_t> edge;
  std::span<std::uint64_t> alone;
  std::span<std::uint64_t> vague;
  std::span<std::uint64_t> unsure;
};

// Equal lengths n of the row, (n + 63) / 64 words each; any alignment; no overlap.
using AmbiguityMasks = void(const MaskRow& row, const PixelMasks& masks) noexcept;

STOF_KERNEL(AmbiguityMasks, ambiguity_masks, kAvx2)

// Lengths as above.
void check_ambiguity_masks(const MaskRow& row, const PixelMasks& masks) noexcept;

// The pixels from x on, x a multiple of 64.
inline MaskRow behind(const MaskRow& row, std::size_t x) noexcept {
  return {row.disparity.subspan(x),
          row.weak.empty() ? row.weak : row.weak.subspan(x),
          {row.support.ratio.subspan(x), row.support.pmd_flags.subspan(x)},
          {row.stereo.low.subspan(x), row.stereo.high.subspan(x)},
          {row.pmd.low.subspan(x), row.pmd.high.subspan(x)},
          row.source.subspan(x),
          row.cause.subspan(x),
          row.max_range,
          row.pmd_range};
}
// What a range is moved by at least.
constexpr QuarterMm least_moved(QuarterMm pmd_range) noexcept {
  return static_cast<QuarterMm>(pmd_range - pmd_range / 16);
}
inline PixelMasks behind(const PixelMasks& masks, std::size_t x) noexcept {
  return {masks.open.subspan(x / 64),  masks.matched.subspan(x / 64), masks.folded.subspan(x / 64),
          masks.weak.subspan(x / 64),  masks.edge.subspan(x / 64),    masks.alone.subspan(x / 64),
          masks.vague.subspan(x / 64), masks.unsure.subspan(x / 64)};
}

}  // namespace stof::dsp
