#include "dsp/fusion/interval/intersect.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kLanes = 16;

// All bits of a lane where it holds.
u16x16 at_most(u16x16 a, u16x16 b) noexcept {
  return as<u16x16>(_mm256_cmpeq_epi16(bits(smaller(a, b)), bits(a)));
}

struct Ranges {
  u16x16 lo;
  u16x16 hi;
  u16x16 present;
};

Ranges clipped(const IntervalRow& row, std::size_t x, u16x16 max_range) noexcept {
  const u16x16 lo = larger(load<u16x16>(&row.low[x]), all(std::uint16_t{1}));
  const u16x16 hi = smaller(load<u16x16>(&row.high[x]), max_range);
  return {lo, hi, at_most(lo, hi)};
}

u16x16 widened(const std::uint8_t* bytes) noexcept {
  // NOLINTNEXTLINE: sixteen bytes of any alignment
  return as<u16x16>(_mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes))));
}

template <typename Value>
u16x16 value_where(u16x16 where, Value value) noexcept {
  return where & all(static_cast<std::uint16_t>(value));
}

u16x16 select(u16x16 where, u16x16 a, u16x16 b) noexcept {
  return as<u16x16>(_mm256_blendv_epi8(bits(b), bits(a), bits(where)));
}

// Two vectors of values below 256.
template <typename Value>
void store_bytes(u16x16 first, u16x16 second, Value* out) noexcept {
  static_assert(sizeof(Value) == 1);
  const __m256i packed = _mm256_packus_epi16(bits(first), bits(second));
  store(reinterpret_cast<std::uint8_t*>(out),  // NOLINT: an enum of bytes
        as<u8x32>(_mm256_permute4x64_epi64(packed, 0xD8)));
}

struct Labels {
  u16x16 source;
  u16x16 cause;
};

// Depth and width of sixteen pixels.
Labels fuse(const IntervalRow& stereo, const IntervalRow& pmd, const SupportRow& support,
            QuarterMm max_range, std::size_t x, const FusedRow& out) noexcept {
  const u16x16 one = all(std::uint16_t{1});
  const Ranges s = clipped(stereo, x, all(max_range));
  const Ranges p = clipped(pmd, x, all(max_range));
  // A missing sensor leaves the other's bounds as they are.
  const u16x16 lo = larger(s.lo & s.present, p.lo & p.present);
  const u16x16 hi = smaller(s.hi | ~s.present, p.hi | ~p.present);
  const u16x16 any = s.present | p.present;
  const u16x16 apart = any & ~at_most(lo, hi);
  const u16x16 no_edge = as<u16x16>(_mm256_cmpeq_epi16(
      bits(widened(&support.pmd_flags[x]) & all(std::uint16_t{kPmdEdge})), _mm256_setzero_si256()));
  const u16x16 unsure = at_most(all(std::uint16_t{kSureRatio}), widened(&support.ratio[x]));
  const u16x16 edge = apart & ~no_edge;
  const u16x16 sure = apart & ~unsure;
  const u16x16 for_stereo = edge & sure;
  const u16x16 for_pmd = apart & ~edge & ~sure;
  const u16x16 conflict = edge ^ sure;
  const u16x16 some = any & ~conflict;
  const u16x16 from = select(for_pmd, p.lo, select(for_stereo, s.lo, lo));
  const u16x16 to = select(for_pmd, p.hi, select(for_stereo, s.hi, hi));
  // (from + to) / 2 rounded down
  const u16x16 middle = (from & to) + ((from ^ to) >> 1);
  store(&out.depth[x], middle & some);
  store(&out.width[x], (to - from + one) & ~one & some);
  const u16x16 sensors =
      (value_where(s.present, Source::kStereo) | value_where(p.present, Source::kPmd)) & ~apart;
  return {sensors | value_where(for_stereo | for_pmd, Source::kResolved) |
              value_where(conflict, Source::kConflict),
          value_where(edge, Cause::kMixedPixel) | value_where(for_pmd, Cause::kStereoAmbiguous) |
              value_where(sure & ~edge, Cause::kContradiction)};
}

}  // namespace

void intersect(const IntervalRow& stereo, const IntervalRow& pmd, const SupportRow& support,
               QuarterMm max_range, const FusedRow& out) noexcept {
  const std::size_t n = out.depth.size();
  STOF_CHECK(stereo.low.size() == n && stereo.high.size() == n && pmd.low.size() == n &&
             pmd.high.size() == n && support.ratio.size() == n && support.pmd_flags.size() == n);
  STOF_CHECK(out.width.size() == n && out.source.size() == n && out.cause.size() == n);
  std::size_t x = 0;
  for (; x + 2 * kLanes <= n; x += 2 * kLanes) {
    const Labels a = fuse(stereo, pmd, support, max_range, x, out);
    const Labels b = fuse(stereo, pmd, support, max_range, x + kLanes, out);
    store_bytes(a.source, b.source, &out.source[x]);
    store_bytes(a.cause, b.cause, &out.cause[x]);
  }
  ref::intersect(
      {stereo.low.subspan(x), stereo.high.subspan(x)}, {pmd.low.subspan(x), pmd.high.subspan(x)},
      {support.ratio.subspan(x), support.pmd_flags.subspan(x)}, max_range,
      {out.depth.subspan(x), out.width.subspan(x), out.source.subspan(x), out.cause.subspan(x)});
}

}  // namespace stof::dsp::avx2
