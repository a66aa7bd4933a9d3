#include "dsp/pmd/range.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp::neon {
namespace {

constexpr int kLanes = 8;

// W at eight phases. The table is read one by one: NEON has no gather for 512 bytes.
uint16x8_t wiggle(uint16x8_t phi, const WigglingSteps& steps) noexcept {
  std::array<std::uint16_t, kLanes> index{};
  vst1q_u16(index.data(), vshrq_n_u16(phi, 9));
  std::array<std::int16_t, kLanes> values{};
  std::array<std::int16_t, kLanes> gains{};
  for (std::size_t k = 0; k < kLanes; ++k) {
    const WigglingStep step = steps[index[k]];
    values[k] = step.value;
    gains[k] = step.gain;
  }
  const int16x8_t gain = vld1q_s16(gains.data());
  const int16x8_t part = vreinterpretq_s16_u16(vandq_u16(phi, vdupq_n_u16(511)));
  const int16x8_t more =
      vcombine_s16(vrshrn_n_s32(vmull_s16(vget_low_s16(gain), vget_low_s16(part)), 9),
                   vrshrn_n_s32(vmull_s16(vget_high_s16(gain), vget_high_s16(part)), 9));
  return vreinterpretq_u16_s16(vaddq_s16(vld1q_s16(values.data()), more));
}

uint16x8_t distance_of(uint16x8_t phi, std::uint16_t range) noexcept {
  const uint16x4_t k = vdup_n_u16(range);
  const uint16x8_t d = vcombine_u16(vrshrn_n_u32(vmull_u16(vget_low_u16(phi), k), 16),
                                    vrshrn_n_u32(vmull_u16(vget_high_u16(phi), k), 16));
  return vmaxq_u16(d, vdupq_n_u16(1));
}

uint16x4_t sigma_of(uint16x4_t amp2, uint16x4_t offset, const RangeParams& params) noexcept {
  const float32x4_t light = vcvtq_f32_u32(vmovl_u16(offset));
  const float32x4_t variance =
      vaddq_f32(vmulq_f32(vdupq_n_f32(params.noise_slope), light), vdupq_n_f32(params.noise_base));
  const float32x4_t amplitude = vcvtq_f32_u32(vmovl_u16(vmax_u16(amp2, vdup_n_u16(1))));
  const float32x4_t sigma = simd::divide(simd::square_root(variance), amplitude);
  const float32x4_t limited = vminq_f32(vmaxq_f32(sigma, vdupq_n_f32(1.0F)), vdupq_n_f32(65535.0F));
  return vqmovun_s32(simd::round_to_int(limited));
}

}  // namespace

void range(std::span<const Phase> phase, std::span<const std::uint16_t> amp2,
           std::span<const std::uint16_t> offset, std::span<const std::uint8_t> flags,
           std::span<const std::int16_t> fixed_pattern, const RangeParams& params,
           std::span<QuarterMm> distance, std::span<QuarterMm> sigma) noexcept {
  const std::size_t n = phase.size();
  STOF_CHECK(amp2.size() == n && offset.size() == n && flags.size() == n);
  STOF_CHECK(distance.size() == n && sigma.size() == n);
  STOF_CHECK(fixed_pattern.empty() || fixed_pattern.size() == n);
  const uint16x8_t falls = vdupq_n_u16(params.phase_falls ? 0xFFFF : 0);
  const uint16x8_t global = vdupq_n_u16(params.global);
  const uint16x8_t missing_bits = vdupq_n_u16(kPmdMissing);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    uint16x8_t phi = vld1q_u16(phase.data() + x);
    phi = vsubq_u16(veorq_u16(phi, falls), falls);  // -phi is ~phi + 1
    if (!fixed_pattern.empty()) {
      phi = vsubq_u16(phi, vreinterpretq_u16_s16(vld1q_s16(fixed_pattern.data() + x)));
    }
    phi = vsubq_u16(phi, global);
    phi = vsubq_u16(phi, wiggle(phi, params.wiggling));
    const uint16x8_t twice = vld1q_u16(amp2.data() + x);
    const uint16x8_t light = vld1q_u16(offset.data() + x);
    const uint16x8_t spread =
        vcombine_u16(sigma_of(vget_low_u16(twice), vget_low_u16(light), params),
                     sigma_of(vget_high_u16(twice), vget_high_u16(light), params));
    const uint16x8_t missing = vtstq_u16(vmovl_u8(vld1_u8(flags.data() + x)), missing_bits);
    vst1q_u16(distance.data() + x, vbicq_u16(distance_of(phi, params.range), missing));
    vst1q_u16(sigma.data() + x, vbicq_u16(spread, missing));
  }
  ref::range(phase.subspan(x), amp2.subspan(x), offset.subspan(x), flags.subspan(x),
             fixed_pattern.empty() ? fixed_pattern : fixed_pattern.subspan(x), params,
             distance.subspan(x), sigma.subspan(x));
}

}  // namespace stof::dsp::neon
