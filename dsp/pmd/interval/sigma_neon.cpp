#include "dsp/pmd/interval/sigma.h"

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

float32x4_t to_float(uint16x4_t v) noexcept { return vcvtq_f32_u32(vmovl_u16(v)); }

// Nearest integer, ties to even, 1 .. 65535.
uint16x4_t limited(float32x4_t sigma) noexcept {
  const float32x4_t inside = vminq_f32(vmaxq_f32(sigma, vdupq_n_f32(1.0F)), vdupq_n_f32(65535.0F));
  return vqmovun_s32(simd::round_to_int(inside));
}

// What amplitudes and their lights tell.
struct Quality {
  uint16x8_t sigma;
  uint16x8_t ratio;
};

// 128 amp2 serves both: 128 sqrt(v) is sqrt(16384 v), to the bit.
constexpr int kScaleBits = 7;
constexpr float kScale = 1 << kScaleBits;

// In every lane.
struct ScaledModel {
  explicit ScaledModel(const NoiseModel& model) noexcept
      : slope(vdupq_n_f32(model.slope * (kScale * kScale))),
        base(vdupq_n_f32(model.base * (kScale * kScale))) {}

  float32x4_t slope;
  float32x4_t base;
};

int32x4_t shot(float32x4_t scaled, float32x4_t light, const ScaledModel& model) noexcept {
  const float32x4_t variance = vaddq_f32(vmulq_f32(model.slope, light), model.base);
  const float32x4_t sigma =
      simd::divide(simd::square_root(variance), vmaxq_f32(scaled, vdupq_n_f32(kScale)));
  return simd::round_to_int(vminq_f32(sigma, vdupq_n_f32(65535.0F)));
}

int32x4_t modulation(float32x4_t scaled, float32x4_t light) noexcept {
  const float32x4_t ratio = simd::divide(scaled, vmaxq_f32(light, vdupq_n_f32(1.0F)));
  return simd::round_to_int(vminq_f32(ratio, vdupq_n_f32(255.0F)));
}

// The lower halves.
uint16x8_t narrow(int32x4_t low, int32x4_t high) noexcept {
  return vuzp1q_u16(vreinterpretq_u16_s32(low), vreinterpretq_u16_s32(high));
}

Quality quality_of(uint16x8_t amp2, uint16x8_t offset, const ScaledModel& model) noexcept {
  const float32x4_t low = vcvtq_f32_u32(vshll_n_u16(vget_low_u16(amp2), kScaleBits));
  const float32x4_t high = vcvtq_f32_u32(vshll_n_u16(vget_high_u16(amp2), kScaleBits));
  const float32x4_t light_low = to_float(vget_low_u16(offset));
  const float32x4_t light_high = to_float(vget_high_u16(offset));
  const uint16x8_t sigma = narrow(shot(low, light_low, model), shot(high, light_high, model));
  return {vmaxq_u16(sigma, vdupq_n_u16(1)),
          narrow(modulation(low, light_low), modulation(high, light_high))};
}

uint16x4_t combined(uint16x4_t sigma, uint16x4_t other) noexcept {
  const float32x4_t a = to_float(sigma);
  const float32x4_t b = to_float(other);
  const float32x4_t both = vaddq_f32(vmulq_f32(a, a), vmulq_f32(b, b));
  return limited(simd::divide(vmulq_f32(a, b), simd::square_root(both)));
}

// Four values of the curve. The table is read one by one: NEON has no gather.
int32x4_t on_curve(uint32x4_t distance, const SigmaCurve& curve) noexcept {
  std::array<std::uint32_t, 4> index{};
  vst1q_u32(index.data(), vshrq_n_u32(distance, 10));
  std::array<std::int32_t, 4> values{};
  std::array<std::int32_t, 4> gains{};
  for (std::size_t k = 0; k < index.size(); ++k) {
    values[k] = curve[index[k]].value;
    gains[k] = curve[index[k]].gain;
  }
  const int32x4_t part = vreinterpretq_s32_u32(vandq_u32(distance, vdupq_n_u32(1023)));
  const int32x4_t more = vrshrq_n_s32(vmulq_s32(vld1q_s32(gains.data()), part), 10);
  return vmaxq_s32(vaddq_s32(vld1q_s32(values.data()), more), vdupq_n_s32(1));
}

}  // namespace

void sigma_and_ratio(std::span<const std::uint16_t> amp2, std::span<const std::uint16_t> offset,
                     const NoiseModel& model, std::span<QuarterMm> sigma,
                     std::span<std::uint8_t> ratio) noexcept {
  const std::size_t n = sigma.size();
  STOF_CHECK(amp2.size() == n && offset.size() == n && ratio.size() == n);
  const ScaledModel scaled(model);
  std::size_t x = 0;
  for (; x + 2 * kLanes <= n; x += 2 * kLanes) {
    const Quality low =
        quality_of(vld1q_u16(amp2.data() + x), vld1q_u16(offset.data() + x), scaled);
    const Quality high = quality_of(vld1q_u16(amp2.data() + x + kLanes),
                                    vld1q_u16(offset.data() + x + kLanes), scaled);
    vst1q_u16(sigma.data() + x, low.sigma);
    vst1q_u16(sigma.data() + x + kLanes, high.sigma);
    vst1q_u8(ratio.data() + x,
             vuzp1q_u8(vreinterpretq_u8_u16(low.ratio), vreinterpretq_u8_u16(high.ratio)));
  }
  ref::sigma_and_ratio(amp2.subspan(x), offset.subspan(x), model, sigma.subspan(x),
                       ratio.subspan(x));
}

void curve_sigma(std::span<const QuarterMm> distance, const SigmaCurve& curve,
                 std::span<QuarterMm> sigma) noexcept {
  STOF_CHECK(distance.size() == sigma.size());
  std::size_t x = 0;
  for (; x + kLanes <= sigma.size(); x += kLanes) {
    const uint16x8_t d = vld1q_u16(distance.data() + x);
    const uint16x8_t found =
        vcombine_u16(vqmovun_s32(on_curve(vmovl_u16(vget_low_u16(d)), curve)),
                     vqmovun_s32(on_curve(vmovl_u16(vget_high_u16(d)), curve)));
    vst1q_u16(sigma.data() + x, vandq_u16(found, vtstq_u16(d, d)));
  }
  ref::curve_sigma(distance.subspan(x), curve, sigma.subspan(x));
}

void combine_sigma(std::span<const QuarterMm> other, std::span<QuarterMm> sigma) noexcept {
  STOF_CHECK(other.size() == sigma.size());
  std::size_t x = 0;
  for (; x + kLanes <= sigma.size(); x += kLanes) {
    const uint16x8_t a = vld1q_u16(sigma.data() + x);
    const uint16x8_t b = vld1q_u16(other.data() + x);
    vst1q_u16(sigma.data() + x, vcombine_u16(combined(vget_low_u16(a), vget_low_u16(b)),
                                             combined(vget_high_u16(a), vget_high_u16(b))));
  }
  ref::combine_sigma(other.subspan(x), sigma.subspan(x));
}

}  // namespace stof::dsp::neon
