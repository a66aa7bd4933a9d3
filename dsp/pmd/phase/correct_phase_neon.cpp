#include "dsp/pmd/phase/correct_phase.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

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

uint16x8_t pattern_of(int16x8_t fixed, int32x4_t scale) noexcept {
  const int32x4_t low = vmulq_s32(vmovl_s16(vget_low_s16(fixed)), scale);
  const int32x4_t high = vmulq_s32(vmovl_s16(vget_high_s16(fixed)), scale);
  return vreinterpretq_u16_s16(vcombine_s16(vrshrn_n_s32(low, 14), vrshrn_n_s32(high, 14)));
}

}  // namespace

void correct_phase(std::span<const Phase> phase, std::span<const std::int16_t> fixed_pattern,
                   const PhaseCorrection& correction, std::span<Phase> corrected) noexcept {
  const std::size_t n = phase.size();
  STOF_CHECK(corrected.size() == n && (fixed_pattern.empty() || fixed_pattern.size() == n));
  const uint16x8_t falls = vdupq_n_u16(correction.phase_falls ? 0xFFFF : 0);
  const uint16x8_t global = vdupq_n_u16(correction.global);
  const int32x4_t scale = vdupq_n_s32(correction.pattern_scale_q14);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    uint16x8_t phi = vld1q_u16(phase.data() + x);
    phi = vsubq_u16(veorq_u16(phi, falls), falls);  // -phi is ~phi + 1
    if (!fixed_pattern.empty()) {
      phi = vsubq_u16(phi, pattern_of(vld1q_s16(fixed_pattern.data() + x), scale));
    }
    phi = vsubq_u16(phi, global);
    vst1q_u16(corrected.data() + x, vsubq_u16(phi, wiggle(phi, correction.wiggling)));
  }
  ref::correct_phase(phase.subspan(x),
                     fixed_pattern.empty() ? fixed_pattern : fixed_pattern.subspan(x), correction,
                     corrected.subspan(x));
}

}  // namespace stof::dsp::neon
