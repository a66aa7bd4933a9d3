#include "dsp/pmd/phase/merge_exposures.h"

#include <cstddef>

#include "dsp/base/simd.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

constexpr int kLanes = 8;

uint16x8_t brighter(uint16x8_t value, std::uint16_t gain_q8) noexcept {
  const uint16x4_t gain = vdup_n_u16(gain_q8);
  return vcombine_u16(vqrshrn_n_u32(vmull_u16(vget_low_u16(value), gain), 8),
                      vqrshrn_n_u32(vmull_u16(vget_high_u16(value), gain), 8));
}

void take(uint8x8_t where, std::span<const std::uint8_t> from, std::span<std::uint8_t> to,
          std::size_t x) noexcept {
  vst1_u8(to.data() + x, vbsl_u8(where, vld1_u8(from.data() + x), vld1_u8(to.data() + x)));
}

void take(uint16x8_t where, uint16x8_t value, std::span<std::uint16_t> to, std::size_t x) noexcept {
  vst1q_u16(to.data() + x, vbslq_u16(where, value, vld1q_u16(to.data() + x)));
}

ExposureRow from(const ExposureRow& row, std::size_t x) noexcept {
  return {.phase = row.phase.subspan(x),
          .amp2 = row.amp2.subspan(x),
          .offset = row.offset.subspan(x),
          .ratio = row.ratio.empty() ? row.ratio : row.ratio.subspan(x),
          .sigma = row.sigma.empty() ? row.sigma : row.sigma.subspan(x),
          .flags = row.flags.subspan(x)};
}

}  // namespace

void merge_exposures(const ExposureRow& shorter, std::uint8_t index, std::uint16_t gain_q8,
                     const ExposureRow& merged, std::span<std::uint8_t> taken) noexcept {
  const std::size_t n = taken.size();
  check_merge_exposures(shorter, merged, n);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const uint8x8_t saturated = vtst_u8(vld1_u8(merged.flags.data() + x), vdup_n_u8(kPmdSaturated));
    const uint16x8_t wide = vreinterpretq_u16_s16(vmovl_s8(vreinterpret_s8_u8(saturated)));
    take(wide, vld1q_u16(shorter.phase.data() + x), merged.phase, x);
    take(wide, brighter(vld1q_u16(shorter.amp2.data() + x), gain_q8), merged.amp2, x);
    take(wide, brighter(vld1q_u16(shorter.offset.data() + x), gain_q8), merged.offset, x);
    if (!merged.sigma.empty()) {
      take(wide, vld1q_u16(shorter.sigma.data() + x), merged.sigma, x);
    }
    if (!merged.ratio.empty()) {
      take(saturated, shorter.ratio, merged.ratio, x);
    }
    take(saturated, shorter.flags, merged.flags, x);
    vst1_u8(taken.data() + x, vbsl_u8(saturated, vdup_n_u8(index), vld1_u8(taken.data() + x)));
  }
  ref::merge_exposures(from(shorter, x), index, gain_q8, from(merged, x), taken.subspan(x));
}

}  // namespace stof::dsp::neon
