#include "dsp/pmd/interval/interval.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

// Eight readings as keys distance << 16 | sigma, in two halves: comparing keys compares readings.
struct Keys {
  uint32x4_t low;
  uint32x4_t high;
};

// Smallest key minus one (a missing reading, key 0, becomes the largest number) and largest key.
struct Extremes {
  Keys smallest_less_one;
  Keys largest;
};

uint32x4_t keys_of(uint16x4_t distance, uint16x4_t sigma) noexcept {
  return vorrq_u32(vshlq_n_u32(vmovl_u16(distance), 16), vmovl_u16(sigma));
}

void take_in(Extremes& e, const QuarterMm* distance, const QuarterMm* sigma) noexcept {
  const uint16x8_t d = vld1q_u16(distance);
  const uint16x8_t s = vld1q_u16(sigma);
  const uint32x4_t one = vdupq_n_u32(1);
  const uint32x4_t low = keys_of(vget_low_u16(d), vget_low_u16(s));
  const uint32x4_t high = keys_of(vget_high_u16(d), vget_high_u16(s));
  e.smallest_less_one.low = vminq_u32(e.smallest_less_one.low, vsubq_u32(low, one));
  e.smallest_less_one.high = vminq_u32(e.smallest_less_one.high, vsubq_u32(high, one));
  e.largest.low = vmaxq_u32(e.largest.low, low);
  e.largest.high = vmaxq_u32(e.largest.high, high);
}

void take_in_row(Extremes& e, std::span<const QuarterMm> distance, std::span<const QuarterMm> sigma,
                 std::size_t x) noexcept {
  for (std::size_t k = x; k < x + 3; ++k) {
    take_in(e, distance.data() + k, sigma.data() + k);
  }
}

uint16x8_t distances(const Keys& keys) noexcept {
  return vcombine_u16(vshrn_n_u32(keys.low, 16), vshrn_n_u32(keys.high, 16));
}
uint16x8_t sigmas(const Keys& keys) noexcept {
  return vcombine_u16(vmovn_u32(keys.low), vmovn_u32(keys.high));
}

uint16x8_t times(uint16x8_t v, int n) noexcept {
  uint16x8_t sum = v;
  for (int k = 1; k < n; ++k) {
    sum = vqaddq_u16(sum, v);
  }
  return sum;
}

uint16x8_t flag(uint16x8_t where, PmdFlag bit) noexcept {
  return vandq_u16(where, vdupq_n_u16(bit));
}

void finish(const Extremes& e, uint16x8_t here, const IntervalLimits& limits, std::uint8_t* flags,
            QuarterMm* low, QuarterMm* high) noexcept {
  const uint32x4_t one = vdupq_n_u32(1);
  const Keys smallest{vaddq_u32(e.smallest_less_one.low, one),
                      vaddq_u32(e.smallest_less_one.high, one)};
  const uint16x8_t nearest = distances(smallest);
  const uint16x8_t farthest = distances(e.largest);
  const uint16x8_t near_sigma = sigmas(smallest);
  const uint16x8_t far_sigma = sigmas(e.largest);
  const uint16x8_t lo = vqsubq_u16(nearest, times(near_sigma, 2));
  const uint16x8_t hi = vqaddq_u16(farthest, times(far_sigma, 2));
  const uint16x8_t none = vdupq_n_u16(0);
  const uint16x8_t present = vtstq_u16(here, here);
  const uint16x8_t wide = vcgtq_u16(vsubq_u16(hi, lo), vdupq_n_u16(limits.widest));
  const uint16x8_t wrapped = vandq_u16(present, vorrq_u16(wide, vceqq_u16(lo, none)));
  const uint16x8_t noise = vqaddq_u16(times(near_sigma, 3), times(far_sigma, 3));
  const uint16x4_t share = vdup_n_u16(limits.slope_q16);
  const uint16x8_t slope = vcombine_u16(vshrn_n_u32(vmull_u16(vget_low_u16(nearest), share), 16),
                                        vshrn_n_u32(vmull_u16(vget_high_u16(nearest), share), 16));
  const uint16x8_t edge = vcgtq_u16(vsubq_u16(farthest, nearest), vqaddq_u16(noise, slope));
  const uint16x8_t range = vdupq_n_u16(limits.range);
  const uint16x8_t beyond = vorrq_u16(vandq_u16(vcgtq_u16(hi, range), vcleq_u16(here, range)),
                                      vceqq_u16(hi, vdupq_n_u16(kMaxQuarterMm)));
  const uint16x8_t bits =
      vorrq_u16(flag(wrapped, kPmdWrapped),
                vandq_u16(present, vorrq_u16(flag(edge, kPmdEdge), flag(beyond, kPmdOutOfRange))));
  vst1_u8(flags, vorr_u8(vld1_u8(flags), vmovn_u16(bits)));
  const uint16x8_t keep = vbicq_u16(present, wrapped);
  vst1q_u16(low, vandq_u16(lo, keep));
  vst1q_u16(high, vandq_u16(hi, keep));
}

}  // namespace

void interval(const IntervalRows& rows, const IntervalLimits& limits, std::span<std::uint8_t> flags,
              std::span<QuarterMm> low, std::span<QuarterMm> high) noexcept {
  const std::size_t n = flags.size();
  STOF_CHECK(low.size() == n && high.size() == n);
  STOF_CHECK(rows.distance_above.size() == n + 2 && rows.sigma_above.size() == n + 2);
  STOF_CHECK(rows.distance_here.size() == n + 2 && rows.sigma_here.size() == n + 2);
  STOF_CHECK(rows.distance_below.size() == n + 2 && rows.sigma_below.size() == n + 2);
  const uint32x4_t all = vdupq_n_u32(0xFFFFFFFF);
  const uint32x4_t zero = vdupq_n_u32(0);
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    Extremes extremes{{all, all}, {zero, zero}};
    take_in_row(extremes, rows.distance_above, rows.sigma_above, x);
    take_in_row(extremes, rows.distance_here, rows.sigma_here, x);
    take_in_row(extremes, rows.distance_below, rows.sigma_below, x);
    finish(extremes, vld1q_u16(rows.distance_here.data() + x + 1), limits, flags.data() + x,
           low.data() + x, high.data() + x);
  }
  ref::interval(behind(rows, x), limits, flags.subspan(x), low.subspan(x), high.subspan(x));
}

}  // namespace stof::dsp::neon
