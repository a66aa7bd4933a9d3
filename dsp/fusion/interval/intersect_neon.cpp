#include "dsp/fusion/interval/intersect.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

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

template <typename Value>
uint16x8_t value_where(uint16x8_t where, Value value) noexcept {
  return vandq_u16(where, vdupq_n_u16(static_cast<std::uint16_t>(value)));
}

template <typename Value>
void store_bytes(uint16x8_t values, Value* out) noexcept {
  static_assert(sizeof(Value) == 1);
  vst1_u8(reinterpret_cast<std::uint8_t*>(out), vmovn_u16(values));  // NOLINT: an enum of bytes
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
    const Ranges s = clipped(stereo, x, max_range);
    const Ranges p = clipped(pmd, x, max_range);
    // A missing sensor leaves the other's bounds as they are.
    const uint16x8_t lo = vmaxq_u16(vandq_u16(s.lo, s.present), vandq_u16(p.lo, p.present));
    const uint16x8_t hi = vminq_u16(vornq_u16(s.hi, s.present), vornq_u16(p.hi, p.present));
    const uint16x8_t any = vorrq_u16(s.present, p.present);
    const uint16x8_t apart = vandq_u16(any, vcgtq_u16(lo, hi));
    const uint16x8_t flags = vmovl_u8(vld1_u8(support.pmd_flags.data() + x));
    const uint16x8_t ratio = vmovl_u8(vld1_u8(support.ratio.data() + x));
    const uint16x8_t edge = vandq_u16(apart, vtstq_u16(flags, vdupq_n_u16(kPmdEdge)));
    const uint16x8_t sure = vandq_u16(apart, vcltq_u16(ratio, vdupq_n_u16(kSureRatio)));
    const uint16x8_t for_stereo = vandq_u16(edge, sure);
    const uint16x8_t for_pmd = vbicq_u16(vbicq_u16(apart, edge), sure);
    const uint16x8_t conflict = veorq_u16(edge, sure);
    const uint16x8_t resolved = vorrq_u16(for_stereo, for_pmd);
    const uint16x8_t some = vbicq_u16(any, conflict);
    const uint16x8_t from = vbslq_u16(for_pmd, p.lo, vbslq_u16(for_stereo, s.lo, lo));
    const uint16x8_t to = vbslq_u16(for_pmd, p.hi, vbslq_u16(for_stereo, s.hi, hi));
    const uint16x8_t even =
        vbicq_u16(vaddq_u16(vsubq_u16(to, from), vdupq_n_u16(1)), vdupq_n_u16(1));
    vst1q_u16(out.depth.data() + x, vandq_u16(vhaddq_u16(from, to), some));
    vst1q_u16(out.width.data() + x, vandq_u16(even, some));
    const uint16x8_t sensors = vbicq_u16(
        vorrq_u16(value_where(s.present, Source::kStereo), value_where(p.present, Source::kPmd)),
        apart);
    const uint16x8_t disputed = vorrq_u16(value_where(resolved, Source::kResolved),
                                          value_where(conflict, Source::kConflict));
    store_bytes(vorrq_u16(sensors, disputed), out.source.data() + x);
    const uint16x8_t why =
        vorrq_u16(value_where(edge, Cause::kMixedPixel),
                  vorrq_u16(value_where(for_pmd, Cause::kStereoAmbiguous),
                            value_where(vbicq_u16(sure, edge), Cause::kContradiction)));
    store_bytes(why, out.cause.data() + x);
  }
  ref::intersect({stereo.low.subspan(x), stereo.high.subspan(x)},
                 {pmd.low.subspan(x), pmd.high.subspan(x)},
                 {support.ratio.subspan(x), support.pmd_flags.subspan(x)}, max_range, tail(out, x));
}

}  // namespace stof::dsp::neon
