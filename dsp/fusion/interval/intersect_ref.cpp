#include "dsp/fusion/interval/intersect.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/pmd/converter.h"

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
  Range range{1, 0};
  Source source = Source::kNone;
  Cause cause = Cause::kNone;
};

Fused resolve(const Range& stereo, const Range& pmd, bool sure, bool edge) noexcept {
  if (sure == edge) {
    return {sure ? stereo : pmd, Source::kResolved,
            sure ? Cause::kMixedPixel : Cause::kStereoAmbiguous};
  }
  return {{1, 0}, Source::kConflict, sure ? Cause::kContradiction : Cause::kMixedPixel};
}

Fused fuse(const Range& stereo, const Range& pmd, bool sure, bool edge) noexcept {
  if (!stereo.present() && !pmd.present()) {
    return {};
  }
  if (!pmd.present()) {
    return {stereo, Source::kStereo, Cause::kNone};
  }
  if (!stereo.present()) {
    return {pmd, Source::kPmd, Cause::kNone};
  }
  const Range both{std::max(stereo.lo, pmd.lo), std::min(stereo.hi, pmd.hi)};
  return both.present() ? Fused{both, Source::kBoth, Cause::kNone}
                        : resolve(stereo, pmd, sure, edge);
}

}  // namespace

void intersect(const IntervalRow& stereo, const IntervalRow& pmd, const SupportRow& support,
               QuarterMm max_range, const FusedRow& out) noexcept {
  const std::size_t n = out.depth.size();
  STOF_CHECK(stereo.low.size() == n && stereo.high.size() == n && pmd.low.size() == n &&
             pmd.high.size() == n && support.ratio.size() == n && support.pmd_flags.size() == n);
  STOF_CHECK(out.width.size() == n && out.source.size() == n && out.cause.size() == n);
  for (std::size_t x = 0; x < n; ++x) {
    const Fused fused = fuse(clipped(stereo, x, max_range), clipped(pmd, x, max_range),
                             support.ratio[x] < kSureRatio, (support.pmd_flags[x] & kPmdEdge) != 0);
    const Range& range = fused.range;
    out.depth[x] = range.present() ? middle_of(range.lo, range.hi) : kNoDepth;
    out.width[x] = range.present() ? width_of(range.lo, range.hi) : QuarterMm{0};
    out.source[x] = fused.source;
    out.cause[x] = fused.cause;
  }
}

}  // namespace stof::dsp::ref
