#include "dsp/fusion/resolve/ambiguity_masks.h"

#include <array>
#include <cstddef>
#include <span>

#include "dsp/base/simd.h"
#include "dsp/fusion/resolve/pixel_masks_neon.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

// Whether both intervals meet once the PMD's is moved by a range. Sums saturate on the right side:
// no low is 0.
uint8x8_t meet_when_moved(const MaskRow& row, std::size_t x) noexcept {
  const uint16x8_t one = vdupq_n_u16(1);
  const uint16x8_t last = vdupq_n_u16(row.max_range);
  const uint16x8_t near = vmaxq_u16(vld1q_u16(&row.stereo.low[x]), one);
  const uint16x8_t far = vminq_u16(vld1q_u16(&row.stereo.high[x]), last);
  const uint16x8_t low = vmaxq_u16(vld1q_u16(&row.pmd.low[x]), one);
  const uint16x8_t high = vminq_u16(vld1q_u16(&row.pmd.high[x]), last);
  const uint16x8_t range = vdupq_n_u16(row.pmd_range);
  const uint16x8_t less = vdupq_n_u16(least_moved(row.pmd_range));
  const uint16x8_t farther =
      vandq_u16(vcleq_u16(vqsubq_u16(near, range), high), vcgeq_u16(vqsubq_u16(far, less), low));
  const uint16x8_t nearer =
      vandq_u16(vcgeq_u16(vqsubq_u16(high, less), near), vcleq_u16(vqsubq_u16(low, range), far));
  return vmovn_u16(vorrq_u16(farther, nearer));
}

uint8x8_t wide(const QuarterMm* low, const QuarterMm* high) noexcept {
  const uint16x8_t from = vld1q_u16(low);
  return is_wide(from, vqsubq_u16(vld1q_u16(high), from));
}

// Few pixels of a picture are in conflict.
uint8x16_t folded(const MaskRow& row, std::size_t x, uint8x16_t conflict) noexcept {
  if (row.pmd_range == 0 || vmaxvq_u8(conflict) == 0) {
    return vdupq_n_u8(0);
  }
  return vandq_u8(conflict, vcombine_u8(meet_when_moved(row, x), meet_when_moved(row, x + 8)));
}

// Of 64 pixels.
struct Masks {
  Mask open;
  Mask matched;
  Mask folded;
  Mask weak;
  Mask edge;
  Mask alone;
  Mask vague;
  Mask unsure;
};

void mark(const MaskRow& row, std::size_t x, std::size_t k, Masks& masks) noexcept {
  const uint8x16_t source = load_bytes(row.source, x);
  const uint8x16_t cause = load_bytes(row.cause, x);
  const uint8x16_t mixed = equals(cause, Cause::kMixedPixel);
  const uint8x16_t resolved = equals(source, Source::kResolved);
  const uint8x16_t conflict = equals(source, Source::kConflict);
  const uint8x16_t broad = vcombine_u8(wide(&row.pmd.low[x], &row.pmd.high[x]),
                                       wide(&row.pmd.low[x + 8], &row.pmd.high[x + 8]));
  const uint8x16_t alone = vorrq_u8(equals(source, Source::kStereo), vandq_u8(resolved, mixed));
  const uint8x16_t both = equals(source, Source::kBoth);
  const uint8x16_t published = vorrq_u8(alone, both);
  const uint8x16_t ratio = vld1q_u8(&row.support.ratio[x]);
  const uint8x16_t distinct = vcltq_u8(ratio, vdupq_n_u8(kNeighbourRatio));
  const uint8x16_t edge = vtstq_u8(vld1q_u8(&row.support.pmd_flags[x]), vdupq_n_u8(kPmdEdge));
  const uint8x16_t none = missing(&row.disparity[x]);
  masks.open[k] =
      vorrq_u8(vandq_u8(equals(source, Source::kPmd), broad), vandq_u8(conflict, mixed));
  masks.matched[k] = vbicq_u8(vandq_u8(published, distinct), none);
  masks.folded[k] = folded(row, x, conflict);
  masks.weak[k] = row.weak.empty() ? vdupq_n_u8(0) : vbicq_u8(none, missing(&row.weak[x]));
  masks.edge[k] = edge;
  masks.alone[k] = alone;
  const uint8x16_t least = vbslq_u8(edge, vdupq_n_u8(kVagueRatio), vdupq_n_u8(kVaguestRatio));
  masks.vague[k] = vandq_u8(vbicq_u8(both, none), vcgeq_u8(ratio, least));
  masks.unsure[k] = vandq_u8(resolved, equals(cause, Cause::kStereoAmbiguous));
}

}  // namespace

void ambiguity_masks(const MaskRow& row, const PixelMasks& marks) noexcept {
  check_ambiguity_masks(row, marks);
  std::size_t x = 0;
  for (; x + kMaskWord <= row.disparity.size(); x += kMaskWord) {
    Masks masks;
    for (std::size_t k = 0; k < masks.open.size(); ++k) {
      mark(row, x + k * kMaskLanes, k, masks);
    }
    store_word(packed(masks.open), &marks.open[x / kMaskWord]);
    store_word(packed(masks.matched), &marks.matched[x / kMaskWord]);
    store_word(packed(masks.folded), &marks.folded[x / kMaskWord]);
    store_word(packed(masks.weak), &marks.weak[x / kMaskWord]);
    store_word(packed(masks.edge), &marks.edge[x / kMaskWord]);
    store_word(packed(masks.alone), &marks.alone[x / kMaskWord]);
    store_word(packed(masks.vague), &marks.vague[x / kMaskWord]);
    store_word(packed(masks.unsure), &marks.unsure[x / kMaskWord]);
  }
  ref::ambiguity_masks(behind(row, x), behind(marks, x));
}

}  // namespace stof::dsp::neon
