#include "dsp/fusion/intersect.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

struct Range {
  int lo;
  int hi;
  bool present() const noexcept { return lo <= hi; }
};

Range clipped(const IntervalRow& row, std::size_t x, QuarterMm max_range) noexcept {
  return {std::max<int>(row.low[x], 1), std::min<int>(row.high[x], max_range)};
}

struct Fused {
  Range range;
  Source source;
};

Fused fuse(const Range& stereo, const Range& pmd, bool edge) noexcept {
  if (!stereo.present() && !pmd.present()) {
    return {pmd, Source::kNone};
  }
  if (!pmd.present()) {
    return {stereo, Source::kStereo};
  }
  if (!stereo.present()) {
    return {pmd, Source::kPmd};
  }
  const Range both{std::max(stereo.lo, pmd.lo), std::min(stereo.hi, pmd.hi)};
  if (both.present()) {
    return {both, Source::kBoth};
  }
  return edge ? Fused{both, Source::kConflict} : Fused{pmd, Source::kResolved};
}

}  // namespace

void intersect(const IntervalRow& stereo, const IntervalRow& pmd,
               std::span<const std::uint8_t> pmd_flags, QuarterMm max_range,
               std::span<QuarterMm> depth, std::span<QuarterMm> width,
               std::span<Source> source) noexcept {
  const std::size_t n = depth.size();
  STOF_CHECK(stereo.low.size() == n && stereo.high.size() == n && pmd.low.size() == n &&
             pmd.high.size() == n && pmd_flags.size() == n && width.size() == n &&
             source.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    const Fused fused = fuse(clipped(stereo, x, max_range), clipped(pmd, x, max_range),
                             (pmd_flags[x] & kPmdEdge) != 0);
    const Range& range = fused.range;
    const bool some = range.present();
    depth[x] = some ? static_cast<QuarterMm>((range.lo + range.hi) / 2) : kNoDepth;
    width[x] = some ? static_cast<QuarterMm>((range.hi - range.lo + 1) / 2 * 2) : QuarterMm{0};
    source[x] = fused.source;
  }
}

}  // namespace stof::dsp::ref
