#include "dsp/pmd/phase/phase.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/phase/phase_narrow_neon.h"
#include "dsp/pmd/phase/phase_steps_neon.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

using phase_steps::Limits;
using phase_steps::lower;
using phase_steps::Narrow;
using phase_steps::NarrowStill;
using phase_steps::Quads;
using phase_steps::Samples;
using phase_steps::Wide;

constexpr std::size_t kLanes = 8;
constexpr std::size_t kStep = 2 * kLanes;

Quads to_float(uint16x8_t v) noexcept {
  return {vcvtq_f32_u32(vmovl_u16(vget_low_u16(v))), vcvtq_f32_u32(vmovl_u16(vget_high_u16(v)))};
}

// t in Q16. Equal numbers give 65534, which stands for the same angle as 65535 does; 0 / 0 is no
// number, and its low half, like that of 192, is 0.
uint16x8_t ratio_q16(const Quads& mn, const Quads& mx) noexcept {
  const float32x4_t most = vdupq_n_f32(65534.0F / 65536.0F);
  const float32x4_t magic = vdupq_n_f32(192.0F);  // next to it singles are 2^-16 apart
  const float32x4_t low = vaddq_f32(vminq_f32(simd::divide(mn.low, mx.low), most), magic);
  const float32x4_t high = vaddq_f32(vminq_f32(simd::divide(mn.high, mx.high), most), magic);
  return lower(vreinterpretq_u32_f32(low), vreinterpretq_u32_f32(high));
}

uint16x8_t octant_angle(uint16x8_t t) noexcept {
  const uint16x8_t half = vshrq_n_u16(t, 1);
  const int16x8_t half_up = vreinterpretq_s16_u16(vsubq_u16(t, half));
  // t^2 >> 17 is half * half_up >> 15: the quarter that an odd t adds does not reach up there.
  const int16x8_t z = simd::product_above(vreinterpretq_s16_u16(half), half_up);
  int16x8_t p = vdupq_n_s16(kArcTangentQ16.back());
  for (std::size_t k = kArcTangentQ16.size() - 1; k-- > 0;) {
    p = vaddq_s16(vdupq_n_s16(kArcTangentQ16[k]), simd::scaled_product(p, z));
  }
  // Below 0 for t = 65534 alone, where the reference adds 0 and this saturates: 8192 both ways.
  const int16x8_t bend = simd::scaled_product(p, vreinterpretq_s16_u16(half));
  return vrshrq_n_u16(vqaddq_u16(t, vreinterpretq_u16_s16(bend)), 3);
}

uint16x8_t fold_octants(uint16x8_t theta, uint16x8_t steep, int16x8_t i, int16x8_t q) noexcept {
  theta = vabdq_u16(theta, vandq_u16(steep, vdupq_n_u16(16384)));
  theta = vabdq_u16(theta, vandq_u16(vreinterpretq_u16_s16(i), vdupq_n_u16(32768)));
  const uint16x8_t below = vreinterpretq_u16_s16(vshrq_n_s16(q, 15));
  return vsubq_u16(veorq_u16(theta, below), below);  // -theta is ~theta + 1
}

struct Pixels {
  uint16x8_t phase;
  uint16x8_t amp2;
  uint16x8_t offset;
  // All ones where the flag is set.
  uint16x8_t saturated;
  uint16x8_t under_range;
  uint16x8_t low_amplitude;
  uint16x8_t low_ratio;
  uint16x8_t asymmetric;
};

template <typename Width>
Pixels eight_pixels(const Samples& raw, const Limits& limits, uint16x8_t& most) noexcept {
  const uint16x8_t largest = vmaxq_u16(vmaxq_u16(raw.a0, raw.a2), vmaxq_u16(raw.a1, raw.a3));
  const uint16x8_t smallest = vminq_u16(vminq_u16(raw.a0, raw.a2), vminq_u16(raw.a1, raw.a3));
  most = vmaxq_u16(most, largest);
  const Samples a = Width::limited(raw);
  const int16x8_t i = Width::less_stray(a.a0, a.a2, limits.stray_i);
  const int16x8_t q = Width::less_stray(a.a3, a.a1, limits.stray_q);
  const uint16x8_t ai = vreinterpretq_u16_s16(vabsq_s16(i));
  const uint16x8_t aq = vreinterpretq_u16_s16(vabsq_s16(q));
  const Quads mx = to_float(vmaxq_u16(ai, aq));
  const Quads mn = to_float(vminq_u16(ai, aq));

  Pixels out{};
  out.phase = fold_octants(octant_angle(ratio_q16(mn, mx)), vcgtq_u16(aq, ai), i, q);
  out.amp2 = Width::magnitude(mn, mx, i, q);
  const uint16x8_t even = vaddq_u16(a.a0, a.a2);
  const uint16x8_t odd = vaddq_u16(a.a1, a.a3);
  out.offset = vqsubq_u16(Width::mean(even, odd), limits.dark);
  out.saturated = vcgeq_u16(largest, limits.saturation);
  out.under_range = vcltq_u16(smallest, limits.lowest);
  out.low_amplitude = vcltq_u16(out.amp2, limits.min_amp2);
  out.low_ratio = vcltq_u16(out.amp2, Width::least_amp2(out.offset, limits));
  if constexpr (Width::kMayBeAsymmetric) {
    out.asymmetric = Width::asymmetric(vabdq_u16(even, odd), out.offset, limits);
  }
  return out;
}

uint8x16_t bytes(uint16x8_t low, uint16x8_t high) noexcept {
  return vuzp1q_u8(vreinterpretq_u8_u16(low), vreinterpretq_u8_u16(high));
}

// Shifts each flag in from the left, the highest first.
static_assert(kPmdSaturated == 1 && kPmdUnderRange == 2 && kPmdLowAmplitude == 4 &&
              kPmdLowRatio == 8 && kPmdAsymmetric == 16);
template <bool kMayBeAsymmetric>
uint8x16_t flags_of(const Pixels& low, const Pixels& high) noexcept {
  uint8x16_t bits = bytes(low.low_ratio, high.low_ratio);
  if constexpr (kMayBeAsymmetric) {
    bits = vsriq_n_u8(bytes(low.asymmetric, high.asymmetric), bits, 1);
    bits = vsriq_n_u8(bits, bytes(low.low_amplitude, high.low_amplitude), 2);
    bits = vsriq_n_u8(bits, bytes(low.under_range, high.under_range), 3);
    bits = vsriq_n_u8(bits, bytes(low.saturated, high.saturated), 4);
    return vshrq_n_u8(bits, 3);
  }
  bits = vsriq_n_u8(bits, bytes(low.low_amplitude, high.low_amplitude), 1);
  bits = vsriq_n_u8(bits, bytes(low.under_range, high.under_range), 2);
  bits = vsriq_n_u8(bits, bytes(low.saturated, high.saturated), 3);
  return vshrq_n_u8(bits, 4);
}

// The first n pixels, n a multiple of kStep; returns the largest sample.
template <typename Width>
std::uint16_t whole_vectors(const SampleRows& samples, const PhaseLimits& limits,
                            const PhaseRow& out, std::size_t n) noexcept {
  const Limits lanes(limits);
  const std::uint16_t* a0 = samples[0].data();
  const std::uint16_t* a1 = samples[1].data();
  const std::uint16_t* a2 = samples[2].data();
  const std::uint16_t* a3 = samples[3].data();
  Phase* phase = out.phase.data();
  std::uint16_t* amp2 = out.amp2.data();
  std::uint16_t* offset = out.offset.data();
  std::uint8_t* flags = out.flags.data();
  uint16x8_t most = vdupq_n_u16(0);
  for (; n != 0; n -= kStep) {
    const Pixels low = eight_pixels<Width>(
        {vld1q_u16(a0), vld1q_u16(a1), vld1q_u16(a2), vld1q_u16(a3)}, lanes, most);
    const Pixels high = eight_pixels<Width>({vld1q_u16(a0 + kLanes), vld1q_u16(a1 + kLanes),
                                             vld1q_u16(a2 + kLanes), vld1q_u16(a3 + kLanes)},
                                            lanes, most);
    vst1q_u16(phase, low.phase);
    vst1q_u16(phase + kLanes, high.phase);
    vst1q_u16(amp2, low.amp2);
    vst1q_u16(amp2 + kLanes, high.amp2);
    vst1q_u16(offset, low.offset);
    vst1q_u16(offset + kLanes, high.offset);
    vst1q_u8(flags, flags_of<Width::kMayBeAsymmetric>(low, high));
    a0 += kStep;
    a1 += kStep;
    a2 += kStep;
    a3 += kStep;
    phase += kStep;
    amp2 += kStep;
    offset += kStep;
    flags += kStep;
  }
  return vmaxvq_u16(most);
}

}  // namespace

void phase(const SampleRows& samples, const PhaseLimits& limits, const PhaseRow& out) noexcept {
  const std::size_t n = out.phase.size();
  for (const std::span<const std::uint16_t>& row : samples) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(out.amp2.size() == n && out.offset.size() == n && out.flags.size() == n);
  STOF_CHECK(limits.ratio_q16 <= kMaxRatioQ16 && limits.asymmetry_slope_q8 <= kMaxAsymmetrySlopeQ8);
  const std::size_t x = n - n % kStep;
  std::uint16_t largest = Narrow::kMostSample + 1;
  if (Narrow::fits(limits)) {
    largest = phase_steps::never_asymmetric(limits)
                  ? whole_vectors<NarrowStill>(samples, limits, out, x)
                  : whole_vectors<Narrow>(samples, limits, out, x);
  }
  if (largest > Narrow::kMostSample) {
    whole_vectors<Wide>(samples, limits, out, x);
  }
  if (x < n) {
    ref::phase(
        {samples[0].subspan(x), samples[1].subspan(x), samples[2].subspan(x),
         samples[3].subspan(x)},
        limits,
        {out.phase.subspan(x), out.amp2.subspan(x), out.offset.subspan(x), out.flags.subspan(x)});
  }
}

}  // namespace stof::dsp::neon
