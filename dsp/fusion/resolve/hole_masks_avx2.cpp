#include "dsp/fusion/resolve/hole_masks.h"

#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/fusion/resolve/pixel_masks_avx2.h"

namespace stof::dsp::avx2 {
namespace {

// Where depth - width / 2 is below 0, 0 does as well.
__m256i is_tight(const QuarterMm* depth, const QuarterMm* width) noexcept {
  const __m256i length = bits(load<u16x16>(width));
  const __m256i half = _mm256_srli_epi16(length, 1);
  return is_narrow(_mm256_subs_epu16(bits(load<u16x16>(depth)), half), length);
}

struct Bits {
  std::uint64_t hole;
  std::uint64_t loose;
  std::uint64_t guess;
};

Bits mark(const HoleRow& row, std::size_t x) noexcept {
  const u8x32 source = load<u8x32>(&row.source[x]);
  const u8x32 cause = load<u8x32>(&row.cause[x]);
  const u8x32 mixed = equals(cause, Cause::kMixedPixel);
  const u8x32 beside = equals(cause, Cause::kStereoAmbiguous) | equals(cause, Cause::kOccluded);
  const u8x32 resolved = equals(source, Source::kResolved);
  const u8x32 tight = narrowed(is_tight(&row.depth[x], &row.width[x]),
                               is_tight(&row.depth[x + 16], &row.width[x + 16]));
  const u8x32 wide = equals(source, Source::kPmd) & ~tight;
  return {mask(equals(source, Source::kNone) | (equals(source, Source::kConflict) & mixed)),
          mask(wide | (resolved & mixed & missing(&row.disparity[x]))),
          mask(wide | (resolved & (mixed | beside)))};
}

}  // namespace

void hole_masks(const HoleRow& row, const HoleMasks& masks) noexcept {
  check_hole_masks(row, masks);
  std::size_t x = 0;
  for (; x + kMaskWord <= row.depth.size(); x += kMaskWord) {
    const Bits a = mark(row, x);
    const Bits b = mark(row, x + kMaskLanes);
    store_word(a.hole, b.hole, &masks.hole[x / kMaskWord]);
    store_word(a.loose, b.loose, &masks.loose[x / kMaskWord]);
    store_word(a.guess, b.guess, &masks.guess[x / kMaskWord]);
  }
  ref::hole_masks(behind(row, x), behind(masks, x));
}

}  // namespace stof::dsp::avx2
