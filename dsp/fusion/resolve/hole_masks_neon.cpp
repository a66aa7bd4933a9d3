#include "dsp/fusion/resolve/hole_masks.h"

#include <cstddef>

#include "dsp/base/simd.h"
#include "dsp/fusion/resolve/pixel_masks_neon.h"

namespace stof::dsp::neon {
namespace {

// Where depth - width / 2 is below 0, 0 does as well.
uint8x8_t is_loose(const QuarterMm* depth, const QuarterMm* width) noexcept {
  const uint16x8_t length = vld1q_u16(width);
  return is_wide(vqsubq_u16(vld1q_u16(depth), vshrq_n_u16(length, 1)), length);
}

struct Marks {
  Mask hole;
  Mask loose;
  Mask guess;
};

void mark(const HoleRow& row, std::size_t x, std::size_t k, Marks& marks) noexcept {
  const uint8x16_t source = load_bytes(row.source, x);
  const uint8x16_t cause = load_bytes(row.cause, x);
  const uint8x16_t mixed = equals(cause, Cause::kMixedPixel);
  const uint8x16_t beside =
      vorrq_u8(equals(cause, Cause::kStereoAmbiguous), equals(cause, Cause::kOccluded));
  const uint8x16_t resolved = equals(source, Source::kResolved);
  const uint8x16_t wide = vandq_u8(equals(source, Source::kPmd),
                                   vcombine_u8(is_loose(&row.depth[x], &row.width[x]),
                                               is_loose(&row.depth[x + 8], &row.width[x + 8])));
  marks.hole[k] =
      vorrq_u8(equals(source, Source::kNone), vandq_u8(equals(source, Source::kConflict), mixed));
  marks.loose[k] = vorrq_u8(wide, vandq_u8(vandq_u8(resolved, mixed), missing(&row.disparity[x])));
  marks.guess[k] = vorrq_u8(wide, vandq_u8(resolved, vorrq_u8(mixed, beside)));
}

}  // namespace

void hole_masks(const HoleRow& row, const HoleMasks& masks) noexcept {
  check_hole_masks(row, masks);
  std::size_t x = 0;
  for (; x + kMaskWord <= row.depth.size(); x += kMaskWord) {
    Marks marks;
    for (std::size_t k = 0; k < marks.hole.size(); ++k) {
      mark(row, x + k * kMaskLanes, k, marks);
    }
    store_word(packed(marks.hole), &masks.hole[x / kMaskWord]);
    store_word(packed(marks.loose), &masks.loose[x / kMaskWord]);
    store_word(packed(marks.guess), &masks.guess[x / kMaskWord]);
  }
  ref::hole_masks(behind(row, x), behind(masks, x));
}

}  // namespace stof::dsp::neon
