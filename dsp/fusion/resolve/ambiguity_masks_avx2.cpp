#include "dsp/fusion/resolve/ambiguity_masks.h"

#include <cstddef>
#include <span>

#include "dsp/base/avx2.h"
#include "dsp/fusion/resolve/pixel_masks_avx2.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::avx2 {
namespace {

u8x32 at_least(u8x32 values, std::uint8_t limit) noexcept {
  return as<u8x32>(_mm256_cmpeq_epi8(bits(larger(values, all(limit))), bits(values)));
}

__m256i narrow_ones(const QuarterMm* low, const QuarterMm* high) noexcept {
  const __m256i from = bits(load<u16x16>(low));
  return is_narrow(from, _mm256_subs_epu16(bits(load<u16x16>(high)), from));
}

__m256i at_most(u16x16 a, u16x16 b) noexcept {
  return _mm256_cmpeq_epi16(bits(smaller(a, b)), bits(a));
}
u16x16 less_by(u16x16 a, u16x16 b) noexcept {
  return as<u16x16>(_mm256_subs_epu16(bits(a), bits(b)));
}

// Whether both intervals meet once the PMD's is moved by a range. Sums saturate on the right side:
// no low is 0.
__m256i meet_when_moved(const MaskRow& row, std::size_t x) noexcept {
  const u16x16 one = all(std::uint16_t{1});
  const u16x16 near = larger(load<u16x16>(&row.stereo.low[x]), one);
  const u16x16 far = smaller(load<u16x16>(&row.stereo.high[x]), all(row.max_range));
  const u16x16 low = larger(load<u16x16>(&row.pmd.low[x]), one);
  const u16x16 high = smaller(load<u16x16>(&row.pmd.high[x]), all(row.max_range));
  const u16x16 range = all(row.pmd_range);
  const u16x16 less = all(least_moved(row.pmd_range));
  const __m256i farther =
      _mm256_and_si256(at_most(less_by(near, range), high), at_most(low, less_by(far, less)));
  const __m256i nearer =
      _mm256_and_si256(at_most(near, less_by(high, less)), at_most(less_by(low, range), far));
  return _mm256_or_si256(farther, nearer);
}

// Few pixels of a picture are in conflict.
std::uint64_t folded(const MaskRow& row, std::size_t x, std::uint64_t conflict) noexcept {
  if (row.pmd_range == 0 || conflict == 0) {
    return 0;
  }
  return conflict & mask(narrowed(meet_when_moved(row, x), meet_when_moved(row, x + 16)));
}

struct Bits {
  std::uint64_t open;
  std::uint64_t matched;
  std::uint64_t folded;
  std::uint64_t weak;
  std::uint64_t edge;
  std::uint64_t alone;
  std::uint64_t vague;
  std::uint64_t unsure;
};

Bits mark(const MaskRow& row, std::size_t x) noexcept {
  const u8x32 source = load<u8x32>(&row.source[x]);
  const u8x32 cause = load<u8x32>(&row.cause[x]);
  const u8x32 mixed = equals(cause, Cause::kMixedPixel);
  const u8x32 resolved = equals(source, Source::kResolved);
  const u8x32 conflict = equals(source, Source::kConflict);
  const u8x32 narrow = narrowed(narrow_ones(&row.pmd.low[x], &row.pmd.high[x]),
                                narrow_ones(&row.pmd.low[x + 16], &row.pmd.high[x + 16]));
  const u8x32 alone = equals(source, Source::kStereo) | (resolved & mixed);
  const u8x32 both = equals(source, Source::kBoth);
  const u8x32 published = alone | both;
  const u8x32 ratio = load<u8x32>(&row.support.ratio[x]);
  const u8x32 alike = at_least(ratio, kNeighbourRatio);
  const u8x32 none = missing(&row.disparity[x]);
  const u8x32 weak = row.weak.empty() ? all(std::uint8_t{0}) : none & ~missing(&row.weak[x]);
  // The flag as the highest bit of its byte.
  const __m256i flags = _mm256_slli_epi16(bits(load<u8x32>(&row.support.pmd_flags[x])), 2);
  static_assert(kPmdEdge == 1 << 5);
  const std::uint64_t edge = mask(as<u8x32>(flags));
  const u8x32 told = both & ~none;
  return {mask((equals(source, Source::kPmd) & ~narrow) | (conflict & mixed)),
          mask(published & ~alike & ~none),
          folded(row, x, mask(conflict)),
          mask(weak),
          edge,
          mask(alone),
          (mask(told & at_least(ratio, kVagueRatio)) & edge) |
              mask(told & at_least(ratio, kVaguestRatio)),
          mask(resolved & equals(cause, Cause::kStereoAmbiguous))};
}

}  // namespace

void ambiguity_masks(const MaskRow& row, const PixelMasks& masks) noexcept {
  check_ambiguity_masks(row, masks);
  std::size_t x = 0;
  for (; x + kMaskWord <= row.disparity.size(); x += kMaskWord) {
    const Bits a = mark(row, x);
    const Bits b = mark(row, x + kMaskLanes);
    store_word(a.open, b.open, &masks.open[x / kMaskWord]);
    store_word(a.matched, b.matched, &masks.matched[x / kMaskWord]);
    store_word(a.folded, b.folded, &masks.folded[x / kMaskWord]);
    store_word(a.weak, b.weak, &masks.weak[x / kMaskWord]);
    store_word(a.edge, b.edge, &masks.edge[x / kMaskWord]);
    store_word(a.alone, b.alone, &masks.alone[x / kMaskWord]);
    store_word(a.vague, b.vague, &masks.vague[x / kMaskWord]);
    store_word(a.unsure, b.unsure, &masks.unsure[x / kMaskWord]);
  }
  ref::ambiguity_masks(behind(row, x), behind(masks, x));
}

}  // namespace stof::dsp::avx2
