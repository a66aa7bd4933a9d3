#include "dsp/fusion/resolve/ambiguity_masks.h"

#include <array>
#include <cstddef>
#include <span>

#include "dsp/base/simd.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 16;
constexpr std::size_t kWord = 64;

template <typename Value>
uint8x16_t equals(uint8x16_t values, Value value) noexcept {
  return vceqq_u8(values, vdupq_n_u8(static_cast<std::uint8_t>(value)));
}

template <typename Value>
uint8x16_t load_bytes(std::span<const Value> row, std::size_t x) noexcept {
  static_assert(sizeof(Value) == 1);
  return vld1q_u8(reinterpret_cast<const std::uint8_t*>(&row[x]));  // NOLINT: an enum of bytes
}

// high - low > low / 12, the quotient rounded down: low * 43691 / 2^19 for every u16.
uint8x8_t wide(const QuarterMm* low, const QuarterMm* high) noexcept {
  static_assert(kNarrowShare == 12);
  constexpr std::uint16_t kTwelfth = 43691;
  const uint16x8_t from = vld1q_u16(low);
  const uint16x4_t lower = vshrn_n_u32(vmull_n_u16(vget_low_u16(from), kTwelfth), 16);
  const uint16x4_t upper = vshrn_n_u32(vmull_n_u16(vget_high_u16(from), kTwelfth), 16);
  const uint16x8_t share = vshrq_n_u16(vcombine_u16(lower, upper), 3);
  return vmovn_u16(vcgtq_u16(vqsubq_u16(vld1q_u16(high), from), share));
}

uint8x16_t missing(const Disparity* disparity) noexcept {
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  return vcombine_u8(vmovn_u16(vceqq_s16(vld1q_s16(&disparity->raw), none)),
                     vmovn_u16(vceqq_s16(vld1q_s16(&disparity[8].raw), none)));
}

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

// Few pixels of a picture are in conflict.
uint8x16_t folded(const MaskRow& row, std::size_t x, uint8x16_t conflict) noexcept {
  if (row.pmd_range == 0 || vmaxvq_u8(conflict) == 0) {
    return vdupq_n_u8(0);
  }
  return vandq_u8(conflict, vcombine_u8(meet_when_moved(row, x), meet_when_moved(row, x + 8)));
}

// Of 64 pixels.
using Mask = std::array<uint8x16_t, kWord / kLanes>;
struct Masks {
  Mask open;
  Mask matched;
  Mask folded;
  Mask weak;
  Mask edge;
  Mask alone;
  Mask vague;
};

void mark(const MaskRow& row, std::size_t x, std::size_t k, Masks& masks) noexcept {
  const uint8x16_t source = load_bytes(row.source, x);
  const uint8x16_t mixed = equals(load_bytes(row.cause, x), Cause::kMixedPixel);
  const uint8x16_t conflict = equals(source, Source::kConflict);
  const uint8x16_t broad = vcombine_u8(wide(&row.pmd.low[x], &row.pmd.high[x]),
                                       wide(&row.pmd.low[x + 8], &row.pmd.high[x + 8]));
  const uint8x16_t alone =
      vorrq_u8(equals(source, Source::kStereo), vandq_u8(equals(source, Source::kResolved), mixed));
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
  masks.vague[k] =
      vandq_u8(vbicq_u8(vandq_u8(both, edge), none), vcgeq_u8(ratio, vdupq_n_u8(kVagueRatio)));
}

// A bit of each byte of 64, by sums of neighbours.
std::uint64_t packed(const Mask& masks) noexcept {
  static constexpr std::array<std::uint8_t, kLanes> kBits{1, 2, 4, 8, 16, 32, 64, 128,
                                                          1, 2, 4, 8, 16, 32, 64, 128};
  const uint8x16_t bits = vld1q_u8(kBits.data());
  const uint8x16_t lower = vpaddq_u8(vandq_u8(masks[0], bits), vandq_u8(masks[1], bits));
  const uint8x16_t upper = vpaddq_u8(vandq_u8(masks[2], bits), vandq_u8(masks[3], bits));
  const uint8x16_t both = vpaddq_u8(lower, upper);
  return vgetq_lane_u64(vreinterpretq_u64_u8(vpaddq_u8(both, both)), 0);
}

void store_word(std::uint64_t bits, std::uint64_t* word) noexcept {
  vst1_u64(word, vdup_n_u64(bits));
}

}  // namespace

void ambiguity_masks(const MaskRow& row, const PixelMasks& marks) noexcept {
  check_ambiguity_masks(row, marks);
  std::size_t x = 0;
  for (; x + kWord <= row.disparity.size(); x += kWord) {
    Masks masks;
    for (std::size_t k = 0; k < masks.open.size(); ++k) {
      mark(row, x + k * kLanes, k, masks);
    }
    store_word(packed(masks.open), &marks.open[x / kWord]);
    store_word(packed(masks.matched), &marks.matched[x / kWord]);
    store_word(packed(masks.folded), &marks.folded[x / kWord]);
    store_word(packed(masks.weak), &marks.weak[x / kWord]);
    store_word(packed(masks.edge), &marks.edge[x / kWord]);
    store_word(packed(masks.alone), &marks.alone[x / kWord]);
    store_word(packed(masks.vague), &marks.vague[x / kWord]);
  }
  ref::ambiguity_masks(behind(row, x), behind(marks, x));
}

}  // namespace stof::dsp::neon
