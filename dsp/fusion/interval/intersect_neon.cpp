#include "dsp/fusion/interval/intersect.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 16;
constexpr std::size_t kHalf = 8;

struct Ranges {
  uint16x8_t lo;
  uint16x8_t hi;
  uint16x8_t present;
};

Ranges clipped(const IntervalRow& row, std::size_t x, QuarterMm max_range) noexcept {
  const uint16x8_t lo = vmaxq_u16(vld1q_u16(row.low.data() + x), vdupq_n_u16(1));
  const uint16x8_t hi = vminq_u16(vld1q_u16(row.high.data() + x), vdupq_n_u16(max_range));
  return {lo, hi, vcleq_u16(lo, hi)};
}

// Of eight pixels.
struct Pair {
  Ranges stereo;
  Ranges pmd;
  uint16x8_t lo;  // of both; a missing sensor leaves the other's bounds as they are
  uint16x8_t hi;
};

Pair both_of(const IntervalRow& stereo, const IntervalRow& pmd, std::size_t x,
             QuarterMm max_range) noexcept {
  const Ranges s = clipped(stereo, x, max_range);
  const Ranges p = clipped(pmd, x, max_range);
  return {s, p, vmaxq_u16(vandq_u16(s.lo, s.present), vandq_u16(p.lo, p.present)),
          vminq_u16(vornq_u16(s.hi, s.present), vornq_u16(p.hi, p.present))};
}

// Masks of two times eight pixels as bytes, and back.
uint8x16_t narrow(uint16x8_t low, uint16x8_t high) noexcept {
  return vuzp1q_u8(vreinterpretq_u8_u16(low), vreinterpretq_u8_u16(high));
}
uint16x8_t lower(uint8x16_t mask) noexcept { return vreinterpretq_u16_u8(vzip1q_u8(mask, mask)); }
uint16x8_t upper(uint8x16_t mask) noexcept { return vreinterpretq_u16_u8(vzip2q_u8(mask, mask)); }

template <typename Value>
uint8x16_t value_where(uint8x16_t where, Value value) noexcept {
  return vandq_u8(where, vdupq_n_u8(static_cast<std::uint8_t>(value)));
}

template <typename Value>
void store_bytes(uint8x16_t values, Value* out) noexcept {
  static_assert(sizeof(Value) == 1);
  vst1q_u8(reinterpret_cast<std::uint8_t*>(out), values);  // NOLINT: an enum of bytes
}

void store_middles(uint16x8_t from, uint16x8_t to, uint16x8_t some, const FusedRow& out,
                   std::size_t x) noexcept {
  const uint16x8_t one = vdupq_n_u16(1);
  const uint16x8_t even = vbicq_u16(vaddq_u16(vsubq_u16(to, from), one), one);
  vst1q_u16(out.depth.data() + x, vandq_u16(vhaddq_u16(from, to), some));
  vst1q_u16(out.width.data() + x, vandq_u16(even, some));
}

// What speaks for whom where both sensors exclude each other.
struct Verdicts {
  Verdicts(uint8x16_t apart, const SupportRow& support, std::size_t x) noexcept
      : edge(vandq_u8(apart,
                      vtstq_u8(vld1q_u8(support.pmd_flags.data() + x), vdupq_n_u8(kPmdEdge)))),
        sure(vandq_u8(apart, vcltq_u8(vld1q_u8(support.ratio.data() + x), vdupq_n_u8(kSureRatio)))),
        for_stereo(vandq_u8(edge, sure)),
        for_pmd(vbicq_u8(vbicq_u8(apart, edge), sure)),
        conflict(veorq_u8(edge, sure)) {}

  uint8x16_t source() const noexcept {
    return vorrq_u8(value_where(vorrq_u8(for_stereo, for_pmd), Source::kResolved),
                    value_where(conflict, Source::kConflict));
  }
  uint8x16_t cause() const noexcept {
    return vorrq_u8(value_where(edge, Cause::kMixedPixel),
                    vorrq_u8(value_where(for_pmd, Cause::kStereoAmbiguous),
                             value_where(vbicq_u8(sure, edge), Cause::kContradiction)));
  }

  uint8x16_t edge;
  uint8x16_t sure;
  uint8x16_t for_stereo;
  uint8x16_t for_pmd;
  uint8x16_t conflict;
};

void store_chosen(const Pair& pair, uint16x8_t for_stereo, uint16x8_t for_pmd, uint16x8_t some,
                  const FusedRow& out, std::size_t x) noexcept {
  const auto [s, p, lo, hi] = pair;
  store_middles(vbslq_u16(for_pmd, p.lo, vbslq_u16(for_stereo, s.lo, lo)),
                vbslq_u16(for_pmd, p.hi, vbslq_u16(for_stereo, s.hi, hi)), some, out, x);
}

FusedRow tail(const FusedRow& row, std::size_t x) noexcept {
  return {row.depth.subspan(x), row.width.subspan(x), row.source.subspan(x), row.cause.subspan(x)};
}

}  // namespace

void intersect(const IntervalRow& stereo, const IntervalRow& pmd, const SupportRow& support,
               QuarterMm max_range, const FusedRow& out) noexcept {
  static_assert(static_cast<int>(Source::kStereo) + static_cast<int>(Source::kPmd) ==
                static_cast<int>(Source::kBoth));
  const std::size_t n = out.depth.size();
  STOF_CHECK(stereo.low.size() == n && stereo.high.size() == n && pmd.low.size() == n &&
             pmd.high.size() == n && support.ratio.size() == n && support.pmd_flags.size() == n);
  STOF_CHECK(out.width.size() == n && out.source.size() == n && out.cause.size() == n);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const Pair low = both_of(stereo, pmd, x, max_range);
    const Pair high = both_of(stereo, pmd, x + kHalf, max_range);
    const uint8x16_t has_stereo = narrow(low.stereo.present, high.stereo.present);
    const uint8x16_t has_pmd = narrow(low.pmd.present, high.pmd.present);
    const uint8x16_t any = vorrq_u8(has_stereo, has_pmd);
    const uint8x16_t apart =
        vandq_u8(any, narrow(vcgtq_u16(low.lo, low.hi), vcgtq_u16(high.lo, high.hi)));
    const uint8x16_t sensors =
        vorrq_u8(value_where(has_stereo, Source::kStereo), value_where(has_pmd, Source::kPmd));
    if (vmaxvq_u8(apart) == 0) {  // nearly everywhere
      store_middles(low.lo, low.hi, lower(any), out, x);
      store_middles(high.lo, high.hi, upper(any), out, x + kHalf);
      store_bytes(sensors, out.source.data() + x);
      store_bytes(vdupq_n_u8(static_cast<std::uint8_t>(Cause::kNone)), out.cause.data() + x);
      continue;
    }
    const Verdicts said(apart, support, x);
    const uint8x16_t some = vbicq_u8(any, said.conflict);
    store_chosen(low, lower(said.for_stereo), lower(said.for_pmd), lower(some), out, x);
    store_chosen(high, upper(said.for_stereo), upper(said.for_pmd), upper(some), out, x + kHalf);
    store_bytes(vorrq_u8(vbicq_u8(sensors, apart), said.source()), out.source.data() + x);
    store_bytes(said.cause(), out.cause.data() + x);
  }
  ref::intersect({stereo.low.subspan(x), stereo.high.subspan(x)},
                 {pmd.low.subspan(x), pmd.high.subspan(x)},
                 {support.ratio.subspan(x), support.pmd_flags.subspan(x)}, max_range, tail(out, x));
}

}  // namespace stof::dsp::neon
