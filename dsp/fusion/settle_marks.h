#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/target.h"
#include "dsp/fusion/intersect.h"
#include "dsp/fusion/settle.h"

namespace stof::dsp {

// What decides how a pixel of a fused row is settled.
struct MarkRow {
  std::span<const Disparity> disparity;
  std::span<const Disparity> weak;  // or empty
  SupportRow support;
  IntervalRow pmd;
  std::span<const Source> source;
  std::span<const Cause> cause;
};

// One bit for each pixel, 64 a word, the first lowest; bits behind the last pixel are 0.
//   open      kPmd with (high - low) kNarrowShare > low, or kConflict by kMixedPixel
//   matched   kStereo, kBoth or kResolved by kMixedPixel, with a disparity and a peak ratio below
//             kNeighbourRatio
//   disputed  kConflict
//   weak      a weak match, and no disparity
//   edge      kPmdEdge
struct Marks {
  std::span<std::uint64_t> open;
  std::span<std::uint64_t> matched;
  std::span<std::uint64_t> disputed;
  std::span<std::uint64_t> weak;
  std::span<std::uint64_t> edge;
};

// Equal lengths n of the row, (n + 63) / 64 words each; any alignment; no overlap.
using SettleMarks = void(const MarkRow& row, const Marks& marks) noexcept;

namespace ref {
SettleMarks settle_marks;
}
namespace neon {
SettleMarks settle_marks;
}
namespace avx2 {
SettleMarks settle_marks;
}
namespace best {
inline constexpr Kernel<SettleMarks> settle_marks{STOF_VARIANTS(settle_marks)};
}

// Lengths as above.
void check_settle_marks(const MarkRow& row, const Marks& marks) noexcept;

// The pixels from x on, x a multiple of 64.
inline MarkRow behind(const MarkRow& row, std::size_t x) noexcept {
  return {row.disparity.subspan(x),
          row.weak.empty() ? row.weak : row.weak.subspan(x),
          {row.support.ratio.subspan(x), row.support.pmd_flags.subspan(x)},
          {row.pmd.low.subspan(x), row.pmd.high.subspan(x)},
          row.source.subspan(x),
          row.cause.subspan(x)};
}
inline Marks behind(const Marks& marks, std::size_t x) noexcept {
  return {marks.open.subspan(x / 64), marks.matched.subspan(x / 64), marks.disputed.subspan(x / 64),
          marks.weak.subspan(x / 64), marks.edge.subspan(x / 64)};
}

}  // namespace stof::dsp
