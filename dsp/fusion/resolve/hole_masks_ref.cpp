#include "dsp/fusion/resolve/hole_masks.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"

namespace stof::dsp {

void check_hole_masks(const HoleRow& row, const HoleMasks& masks) noexcept {
  const std::size_t n = row.depth.size();
  const std::size_t words = (n + 63) / 64;
  STOF_CHECK(row.width.size() == n && row.source.size() == n && row.cause.size() == n &&
             row.disparity.size() == n);
  STOF_CHECK(masks.hole.size() == words && masks.loose.size() == words &&
             masks.guess.size() == words);
}

namespace ref {

void hole_masks(const HoleRow& row, const HoleMasks& masks) noexcept {
  check_hole_masks(row, masks);
  std::ranges::fill(masks.hole, 0U);
  std::ranges::fill(masks.loose, 0U);
  std::ranges::fill(masks.guess, 0U);
  for (std::size_t x = 0; x < row.depth.size(); ++x) {
    const Source source = row.source[x];
    const bool mixed = row.cause[x] == Cause::kMixedPixel;
    const int low = row.depth[x] - row.width[x] / 2;
    const bool hole = source == Source::kNone || (source == Source::kConflict && mixed);
    const bool wide = source == Source::kPmd && row.width[x] * kNarrowShare > low;
    const bool resolved = source == Source::kResolved;
    const bool loose = wide || (resolved && mixed && !row.disparity[x].valid());
    const bool guess = wide || (resolved && (mixed || row.cause[x] == Cause::kStereoAmbiguous ||
                                             row.cause[x] == Cause::kOccluded));
    const std::uint64_t bit = std::uint64_t{1} << (x % 64);
    masks.hole[x / 64] |= hole ? bit : 0;
    masks.loose[x / 64] |= loose ? bit : 0;
    masks.guess[x / 64] |= guess ? bit : 0;
  }
}

}  // namespace ref
}  // namespace stof::dsp
