#include "dsp/fusion/resolve/ambiguity_masks.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

void check_ambiguity_masks(const MaskRow& row, const PixelMasks& masks) noexcept {
  const std::size_t n = row.disparity.size();
  const std::size_t words = (n + 63) / 64;
  STOF_CHECK((row.weak.empty() || row.weak.size() == n) && row.support.ratio.size() == n &&
             row.support.pmd_flags.size() == n);
  STOF_CHECK(row.stereo.low.size() == n && row.stereo.high.size() == n);
  STOF_CHECK(row.pmd.low.size() == n && row.pmd.high.size() == n && row.source.size() == n &&
             row.cause.size() == n);
  STOF_CHECK(masks.open.size() == words && masks.matched.size() == words &&
             masks.folded.size() == words && masks.weak.size() == words &&
             masks.edge.size() == words && masks.alone.size() == words &&
             masks.vague.size() == words && masks.unsure.size() == words);
}

namespace ref {
namespace {

bool is_folded(const MaskRow& row, std::size_t x) noexcept {
  const int range = row.pmd_range;
  const int less = least_moved(row.pmd_range);
  const int near = std::max<int>(row.stereo.low[x], 1);
  const int far = std::min<int>(row.stereo.high[x], row.max_range);
  const int low = std::max<int>(row.pmd.low[x], 1);
  const int high = std::min<int>(row.pmd.high[x], row.max_range);
  return range != 0 && ((near <= high + range && low + less <= far) ||
                        (near <= high - less && low - range <= far));
}

}  // namespace

void ambiguity_masks(const MaskRow& row, const PixelMasks& masks) noexcept {
  check_ambiguity_masks(row, masks);
  for (const auto& words : {masks.open, masks.matched, masks.folded, masks.weak, masks.edge,
                            masks.alone, masks.vague, masks.unsure}) {
    std::ranges::fill(words, 0U);
  }
  for (std::size_t x = 0; x < row.disparity.size(); ++x) {
    const Source source = row.source[x];
    const bool mixed = row.cause[x] == Cause::kMixedPixel;
    const bool wide = (row.pmd.high[x] - row.pmd.low[x]) * kNarrowShare > row.pmd.low[x];
    const bool conflict = source == Source::kConflict;
    const bool open = (source == Source::kPmd && wide) || (conflict && mixed);
    const bool alone = source == Source::kStereo || (source == Source::kResolved && mixed);
    const bool published = alone || source == Source::kBoth;
    const bool matched =
        published && row.support.ratio[x] < kNeighbourRatio && row.disparity[x].valid();
    const bool weak = !row.weak.empty() && row.weak[x].valid() && !row.disparity[x].valid();
    const bool edge = (row.support.pmd_flags[x] & kPmdEdge) != 0;
    const bool vague = source == Source::kBoth && row.disparity[x].valid() &&
                       row.support.ratio[x] >= (edge ? kVagueRatio : kVaguestRatio);
    const bool unsure = source == Source::kResolved && row.cause[x] == Cause::kStereoAmbiguous;
    const std::uint64_t bit = std::uint64_t{1} << (x % 64);
    masks.open[x / 64] |= open ? bit : 0;
    masks.matched[x / 64] |= matched ? bit : 0;
    masks.folded[x / 64] |= conflict && is_folded(row, x) ? bit : 0;
    masks.weak[x / 64] |= weak ? bit : 0;
    masks.edge[x / 64] |= edge ? bit : 0;
    masks.alone[x / 64] |= alone ? bit : 0;
    masks.vague[x / 64] |= vague ? bit : 0;
    masks.unsure[x / 64] |= unsure ? bit : 0;
  }
}

}  // namespace ref
}  // namespace stof::dsp
