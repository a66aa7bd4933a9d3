#include "dsp/fusion/intersect.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

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

uint16x8_t source_where(uint16x8_t where, Source source) noexcept {
  return vandq_u16(where, vdupq_n_u16(static_cast<std::uint16_t>(source)));
}

}  // namespace

void intersect(const IntervalRow& stereo, const IntervalRow& pmd,
               std::span<const std::uint8_t> pmd_flags, QuarterMm max_range,
               std::span<QuarterMm> depth, std::span<QuarterMm> width,
               std::span<Source> source) noexcept {
  static_assert(static_cast<int>(Source::kStereo) + static_cast<int>(Source::kPmd) ==
                static_cast<int>(Source::kBoth));
  const std::size_t n = depth.size();
  STOF_CHECK(stereo.low.size() == n && stereo.high.size() == n && pmd.low.size() == n &&
             pmd.high.size() == n && pmd_flags.size() == n && width.size() == n &&
             source.size() == n);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const Ranges s = clipped(stereo, x, max_range);
    const Ranges p = clipped(pmd, x, max_range);
    // A missing sensor leaves the other's bounds as they are.
    const uint16x8_t lo = vmaxq_u16(vandq_u16(s.lo, s.present), vandq_u16(p.lo, p.present));
    const uint16x8_t hi = vminq_u16(vornq_u16(s.hi, s.present), vornq_u16(p.hi, p.present));
    const uint16x8_t any = vorrq_u16(s.present, p.present);
    const uint16x8_t apart = vandq_u16(any, vcgtq_u16(lo, hi));
    const uint16x8_t flags = vmovl_u8(vld1_u8(pmd_flags.data() + x));
    const uint16x8_t resolved = vbicq_u16(apart, vtstq_u16(flags, vdupq_n_u16(kPmdEdge)));
    const uint16x8_t conflict = vbicq_u16(apart, resolved);
    const uint16x8_t some = vbicq_u16(any, conflict);
    const uint16x8_t from = vbslq_u16(resolved, p.lo, lo);
    const uint16x8_t to = vbslq_u16(resolved, p.hi, hi);
    const uint16x8_t even =
        vbicq_u16(vaddq_u16(vsubq_u16(to, from), vdupq_n_u16(1)), vdupq_n_u16(1));
    vst1q_u16(depth.data() + x, vandq_u16(vhaddq_u16(from, to), some));
    vst1q_u16(width.data() + x, vandq_u16(even, some));
    const uint16x8_t sensors = vbicq_u16(
        vorrq_u16(source_where(s.present, Source::kStereo), source_where(p.present, Source::kPmd)),
        apart);
    const uint16x8_t disputed = vorrq_u16(source_where(resolved, Source::kResolved),
                                          source_where(conflict, Source::kConflict));
    std::uint8_t* const out =
        reinterpret_cast<std::uint8_t*>(source.data() + x);  // NOLINT: Source is a std::uint8_t
    vst1_u8(out, vmovn_u16(vorrq_u16(sensors, disputed)));
  }
  ref::intersect({stereo.low.subspan(x), stereo.high.subspan(x)},
                 {pmd.low.subspan(x), pmd.high.subspan(x)}, pmd_flags.subspan(x), max_range,
                 depth.subspan(x), width.subspan(x), source.subspan(x));
}

}  // namespace stof::dsp::neon
