#include "dsp/pmd/range/to_quarter_mm.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/pmd_maps.h"
#include "dsp/pmd/range/phase_to_distance.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

uint32x4_t scaled(uint32x4_t units, uint32_t unit_q30) noexcept {
  const uint32x2_t scale = vdup_n_u32(unit_q30);
  return vcombine_u32(vrshrn_n_u64(vmull_u32(vget_low_u32(units), scale), 30),
                      vrshrn_n_u64(vmull_u32(vget_high_u32(units), scale), 30));
}

// What four readings publish, but for their flags.
struct Four {
  uint32x4_t units;
  uint32x4_t quarters;
  uint32x4_t far;  // all ones where distance cannot hold it
};

Four four(uint32x4_t reading, std::uint32_t unit_q30, uint32x4_t missing) noexcept {
  const uint32x4_t one = vdupq_n_u32(1);
  const uint32x4_t units = vminq_u32(vmaxq_u32(reading, one), vdupq_n_u32(kMostUnits));
  const uint32x4_t exact = unit_q30 == kQuarterMmQ30 ? units : scaled(units, unit_q30);
  const uint32x4_t quarters = vmaxq_u32(exact, one);
  const uint32x4_t far = vcgtq_u32(quarters, vdupq_n_u32(kMaxQuarterMm));
  return {vbicq_u32(units, missing), quarters, vbicq_u32(far, missing)};
}

// All ones or none of a 16-bit lane in 32 bits.
uint32x4_t widen(uint16x4_t mask) noexcept {
  return vreinterpretq_u32_s32(vmovl_s16(vreinterpret_s16_u16(mask)));
}

}  // namespace

void to_quarter_mm(std::span<std::uint32_t> reading, std::uint32_t unit_q30,
                   std::span<std::uint8_t> flags, std::span<QuarterMm> distance,
                   std::span<QuarterMm> sigma) noexcept {
  const std::size_t n = reading.size();
  STOF_CHECK(flags.size() == n && distance.size() == n && sigma.size() == n);
  STOF_CHECK(unit_q30 <= kQuarterMmQ30);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const uint16x8_t bits = vmovl_u8(vld1_u8(flags.data() + x));
    const uint16x8_t missing = vtstq_u16(bits, vdupq_n_u16(kPmdMissing));
    const Four low = four(vld1q_u32(reading.data() + x), unit_q30, widen(vget_low_u16(missing)));
    const Four high =
        four(vld1q_u32(reading.data() + x + 4), unit_q30, widen(vget_high_u16(missing)));
    const uint16x8_t far = vcombine_u16(vmovn_u32(low.far), vmovn_u32(high.far));
    const uint16x8_t none = vorrq_u16(missing, far);
    const uint16x8_t quarters = vcombine_u16(vmovn_u32(low.quarters), vmovn_u32(high.quarters));
    const uint16x8_t more = vandq_u16(far, vdupq_n_u16(kPmdOutOfRange));
    vst1q_u32(reading.data() + x, low.units);
    vst1q_u32(reading.data() + x + 4, high.units);
    vst1q_u16(distance.data() + x, vbicq_u16(quarters, none));
    vst1q_u16(sigma.data() + x, vbicq_u16(vld1q_u16(sigma.data() + x), none));
    vst1_u8(flags.data() + x, vmovn_u16(vorrq_u16(bits, more)));
  }
  ref::to_quarter_mm(reading.subspan(x), unit_q30, flags.subspan(x), distance.subspan(x),
                     sigma.subspan(x));
}

}  // namespace stof::dsp::neon
