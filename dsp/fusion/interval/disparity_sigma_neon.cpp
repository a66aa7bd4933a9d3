#include "dsp/fusion/interval/disparity_sigma.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

// max(raw - infinity, 0) / 8, saturated to a byte; a difference above 32767 is a large one.
uint8x8_t most(int16x8_t raw, int16x8_t infinity) noexcept {
  const int16x8_t parallax = vmaxq_s16(vqsubq_s16(raw, infinity), vdupq_n_s16(0));
  return vqmovun_s16(vshrq_n_s16(parallax, 3));
}
static_assert(kHalfWidthShare == 1 << 3);

}  // namespace

void disparity_sigma(std::span<const Disparity> disparity, std::span<const std::uint8_t> ratio,
                     const SigmaTable& table, std::int16_t infinity_raw,
                     std::span<std::uint8_t> half) noexcept {
  constexpr std::size_t kLanes = 16;
  STOF_CHECK(ratio.size() == disparity.size() && half.size() == disparity.size());
  const uint8x16_t steps = vld1q_u8(table.data());
  const int16x8_t infinity = vdupq_n_s16(infinity_raw);
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  std::size_t x = 0;
  for (; x + kLanes <= half.size(); x += kLanes) {
    const int16x8_t low = vld1q_s16(&disparity[x].raw);
    const int16x8_t high = vld1q_s16(&disparity[x + 8].raw);
    const uint8x16_t missing =
        vcombine_u8(vmovn_u16(vceqq_s16(low, none)), vmovn_u16(vceqq_s16(high, none)));
    const uint8x16_t limit = vcombine_u8(most(low, infinity), most(high, infinity));
    const uint8x16_t wanted = simd::look_up(steps, vshrq_n_u8(vld1q_u8(ratio.data() + x), 4));
    const uint8x16_t half_width = vmaxq_u8(vminq_u8(wanted, limit), vdupq_n_u8(kLeastHalfWidth));
    vst1q_u8(half.data() + x, vbicq_u8(half_width, missing));
  }
  ref::disparity_sigma(disparity.subspan(x), ratio.subspan(x), table, infinity_raw,
                       half.subspan(x));
}

}  // namespace stof::dsp::neon
