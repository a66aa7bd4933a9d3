#include "dsp/pmd/phase.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

// sqrt(1 + z) on 0 <= z <= 1 within 1.3e-5, lowest coefficient first: an estimate of amp2 (at most
// 32767 times that) which is less than one off; comparing whole numbers then repairs it.
constexpr std::array<float, 5> kRoot{1.0000126F, 0.4993615F, -0.1195158F, 0.0445398F, -0.0101921F};

struct Quads {
  float32x4_t low;
  float32x4_t high;
};

Quads to_float(uint16x8_t v) noexcept {
  return {vcvtq_f32_u32(vmovl_u16(vget_low_u16(v))), vcvtq_f32_u32(vmovl_u16(vget_high_u16(v)))};
}

uint16x8_t narrow(uint32x4_t low, uint32x4_t high) noexcept {
  return vcombine_u16(vmovn_u32(low), vmovn_u32(high));
}

// min(65535, ratio * 65536 to nearest).
uint16x8_t to_q16(Quads ratio) noexcept {
  const float32x4_t one = vdupq_n_f32(65536.0F);
  return vcombine_u16(vqmovun_s32(simd::round_to_int(vmulq_f32(ratio.low, one))),
                      vqmovun_s32(simd::round_to_int(vmulq_f32(ratio.high, one))));
}

uint16x8_t octant_angle(uint16x8_t t) noexcept {
  const uint16x8_t square =
      vcombine_u16(vshrn_n_u32(vmull_u16(vget_low_u16(t), vget_low_u16(t)), 16),
                   vshrn_n_u32(vmull_u16(vget_high_u16(t), vget_high_u16(t)), 16));
  const int16x8_t z = vreinterpretq_s16_u16(vshrq_n_u16(square, 1));
  int16x8_t p = vdupq_n_s16(kArcTangentQ16.back());
  for (std::size_t k = kArcTangentQ16.size() - 1; k-- > 0;) {
    p = vaddq_s16(vdupq_n_s16(kArcTangentQ16[k]), vqrdmulhq_s16(p, z));
  }
  const int16x8_t bend = vqrdmulhq_s16(p, vreinterpretq_s16_u16(vshrq_n_u16(t, 1)));
  const uint16x8_t bend_up = vreinterpretq_u16_s16(vmaxq_s16(bend, vdupq_n_s16(0)));
  return vrshrq_n_u16(vqaddq_u16(t, bend_up), 3);
}

uint16x8_t fold_octants(uint16x8_t theta, uint16x8_t steep, int16x8_t i, int16x8_t q) noexcept {
  theta = vbslq_u16(steep, vsubq_u16(vdupq_n_u16(16384), theta), theta);
  theta = vbslq_u16(vcltq_s16(i, vdupq_n_s16(0)), vsubq_u16(vdupq_n_u16(32768), theta), theta);
  return vbslq_u16(vcltq_s16(q, vdupq_n_s16(0)), vsubq_u16(vdupq_n_u16(0), theta), theta);
}

// What to add to and subtract from an estimate `root` of sqrt(n): all ones where it is one too low
// or one too high.
struct Repair {
  uint32x4_t up;
  uint32x4_t down;
};

Repair repair(uint32x4_t root, uint32x4_t n) noexcept {
  const uint32x4_t square = vmulq_u32(root, root);
  return {vcgtq_u32(n, vaddq_u32(square, root)), vcleq_u32(vaddq_u32(n, root), square)};
}

uint32x4_t root_estimate(float32x4_t mx, float32x4_t ratio) noexcept {
  const float32x4_t z = vmulq_f32(ratio, ratio);
  float32x4_t s = vdupq_n_f32(kRoot.back());
  for (std::size_t k = kRoot.size() - 1; k-- > 0;) {
    s = vaddq_f32(vdupq_n_f32(kRoot[k]), vmulq_f32(s, z));
  }
  return vreinterpretq_u32_s32(simd::round_to_int(vmulq_f32(mx, s)));
}

uint16x8_t magnitude(Quads mx, Quads ratio, int16x8_t i, int16x8_t q) noexcept {
  const int16x4_t i_low = vget_low_s16(i);
  const int16x4_t q_low = vget_low_s16(q);
  const int16x4_t i_high = vget_high_s16(i);
  const int16x4_t q_high = vget_high_s16(q);
  const uint32x4_t n_low = vreinterpretq_u32_s32(vmlal_s16(vmull_s16(i_low, i_low), q_low, q_low));
  const uint32x4_t n_high =
      vreinterpretq_u32_s32(vmlal_s16(vmull_s16(i_high, i_high), q_high, q_high));
  const uint32x4_t low = root_estimate(mx.low, ratio.low);
  const uint32x4_t high = root_estimate(mx.high, ratio.high);
  const Repair at_low = repair(low, n_low);
  const Repair at_high = repair(high, n_high);
  const uint16x8_t one = vdupq_n_u16(1);
  const uint16x8_t up = vandq_u16(narrow(at_low.up, at_high.up), one);
  const uint16x8_t down = vandq_u16(narrow(at_low.down, at_high.down), one);
  // Saturating: the root of 0 also reads as one too high.
  return vqsubq_u16(vaddq_u16(narrow(low, high), up), down);
}

// Limits in every lane.
struct Limits {
  uint16x8_t saturation;
  uint16x8_t lowest;
  uint16x8_t dark;
  uint16x8_t min_amp2;
  uint32x4_t ratio;
  uint32x4_t asymmetry_base;
  uint32x4_t asymmetry_slope;
  int16x8_t stray_i;
  int16x8_t stray_q;
};

// a - b without stray light; both below 32768.
int16x8_t less_stray(uint16x8_t a, uint16x8_t b, int16x8_t stray) noexcept {
  const int16x8_t difference = vreinterpretq_s16_u16(vsubq_u16(a, b));
  return vmaxq_s16(vqsubq_s16(difference, stray), vdupq_n_s16(-32767));
}

uint16x8_t ratio_of(uint16x8_t amp2, uint16x8_t offset) noexcept {
  const Quads twice = to_float(amp2);
  const Quads light = to_float(vmaxq_u16(offset, vdupq_n_u16(1)));
  const float32x4_t scale = vdupq_n_f32(128.0F);
  const float32x4_t most = vdupq_n_f32(255.0F);
  const float32x4_t low = simd::divide(vmulq_f32(twice.low, scale), light.low);
  const float32x4_t high = simd::divide(vmulq_f32(twice.high, scale), light.high);
  return narrow(vreinterpretq_u32_s32(simd::round_to_int(vminq_f32(low, most))),
                vreinterpretq_u32_s32(simd::round_to_int(vminq_f32(high, most))));
}

uint16x8_t ratio_floor(uint16x8_t offset, const Limits& limits) noexcept {
  return vcombine_u16(vshrn_n_u32(vmulq_u32(vmovl_u16(vget_low_u16(offset)), limits.ratio), 16),
                      vshrn_n_u32(vmulq_u32(vmovl_u16(vget_high_u16(offset)), limits.ratio), 16));
}

uint32x4_t too_uneven(uint16x4_t uneven, uint16x4_t offset, const Limits& limits) noexcept {
  const uint32x4_t shot = vshrq_n_u32(vmulq_u32(vmovl_u16(offset), limits.asymmetry_slope), 8);
  return vcgtq_u32(vmull_u16(uneven, uneven), vqaddq_u32(limits.asymmetry_base, shot));
}

uint16x8_t flag(uint16x8_t where, PmdFlag bit) noexcept {
  return vandq_u16(where, vdupq_n_u16(bit));
}

struct Samples {
  uint16x8_t a0;
  uint16x8_t a1;
  uint16x8_t a2;
  uint16x8_t a3;
};

struct Pixels {
  uint16x8_t phase;
  uint16x8_t amp2;
  uint16x8_t offset;
  uint8x8_t ratio;
  uint8x8_t flags;
};

Pixels eight_pixels(const Samples& raw, const Limits& limits) noexcept {
  const uint16x8_t largest = vmaxq_u16(vmaxq_u16(raw.a0, raw.a1), vmaxq_u16(raw.a2, raw.a3));
  const uint16x8_t smallest = vminq_u16(vminq_u16(raw.a0, raw.a1), vminq_u16(raw.a2, raw.a3));
  const uint16x8_t top = vdupq_n_u16(32767);
  const Samples a{vminq_u16(raw.a0, top), vminq_u16(raw.a1, top), vminq_u16(raw.a2, top),
                  vminq_u16(raw.a3, top)};
  const int16x8_t i = less_stray(a.a0, a.a2, limits.stray_i);
  const int16x8_t q = less_stray(a.a3, a.a1, limits.stray_q);
  const uint16x8_t ai = vreinterpretq_u16_s16(vabsq_s16(i));
  const uint16x8_t aq = vreinterpretq_u16_s16(vabsq_s16(q));
  const Quads mx = to_float(vmaxq_u16(vmaxq_u16(ai, aq), vdupq_n_u16(1)));
  const Quads mn = to_float(vminq_u16(ai, aq));
  const Quads ratio{simd::divide(mn.low, mx.low), simd::divide(mn.high, mx.high)};

  Pixels out{};
  out.phase = fold_octants(octant_angle(to_q16(ratio)), vcgtq_u16(aq, ai), i, q);
  out.amp2 = magnitude(mx, ratio, i, q);
  const uint16x8_t even = vaddq_u16(a.a0, a.a2);
  const uint16x8_t odd = vaddq_u16(a.a1, a.a3);
  const uint16x8_t mean =
      vcombine_u16(vrshrn_n_u32(vaddl_u16(vget_low_u16(even), vget_low_u16(odd)), 2),
                   vrshrn_n_u32(vaddl_u16(vget_high_u16(even), vget_high_u16(odd)), 2));
  out.offset = vqsubq_u16(mean, limits.dark);
  out.ratio = vmovn_u16(ratio_of(out.amp2, out.offset));
  const uint16x8_t uneven = vabdq_u16(even, odd);
  const uint16x8_t asymmetric =
      narrow(too_uneven(vget_low_u16(uneven), vget_low_u16(out.offset), limits),
             too_uneven(vget_high_u16(uneven), vget_high_u16(out.offset), limits));
  uint16x8_t flags = flag(vcgeq_u16(largest, limits.saturation), kPmdSaturated);
  flags = vorrq_u16(flags, flag(vcltq_u16(smallest, limits.lowest), kPmdUnderRange));
  flags = vorrq_u16(flags, flag(vcltq_u16(out.amp2, limits.min_amp2), kPmdLowAmplitude));
  flags =
      vorrq_u16(flags, flag(vcltq_u16(out.amp2, ratio_floor(out.offset, limits)), kPmdLowRatio));
  out.flags = vmovn_u16(vorrq_u16(flags, flag(asymmetric, kPmdAsymmetric)));
  return out;
}

}  // namespace

void phase(const SampleRows& samples, const PhaseLimits& limits, const PhaseRow& out) noexcept {
  const std::size_t n = out.phase.size();
  for (const std::span<const std::uint16_t>& row : samples) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(out.amp2.size() == n && out.offset.size() == n);
  STOF_CHECK(out.ratio.size() == n && out.flags.size() == n);
  STOF_CHECK(limits.ratio_q16 <= kMaxRatioQ16 && limits.asymmetry_slope_q8 <= kMaxAsymmetrySlopeQ8);
  const Limits lanes{vdupq_n_u16(limits.saturation),
                     vdupq_n_u16(limits.lowest),
                     vdupq_n_u16(limits.dark),
                     vdupq_n_u16(limits.min_amp2),
                     vdupq_n_u32(limits.ratio_q16),
                     vdupq_n_u32(limits.asymmetry_base),
                     vdupq_n_u32(limits.asymmetry_slope_q8),
                     vdupq_n_s16(limits.stray_i),
                     vdupq_n_s16(limits.stray_q)};
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    const Pixels pixels =
        eight_pixels({vld1q_u16(samples[0].data() + x), vld1q_u16(samples[1].data() + x),
                      vld1q_u16(samples[2].data() + x), vld1q_u16(samples[3].data() + x)},
                     lanes);
    vst1q_u16(out.phase.data() + x, pixels.phase);
    vst1q_u16(out.amp2.data() + x, pixels.amp2);
    vst1q_u16(out.offset.data() + x, pixels.offset);
    vst1_u8(out.ratio.data() + x, pixels.ratio);
    vst1_u8(out.flags.data() + x, pixels.flags);
  }
  ref::phase(
      {samples[0].subspan(x), samples[1].subspan(x), samples[2].subspan(x), samples[3].subspan(x)},
      limits,
      {out.phase.subspan(x), out.amp2.subspan(x), out.offset.subspan(x), out.ratio.subspan(x),
       out.flags.subspan(x)});
}

}  // namespace stof::dsp::neon
