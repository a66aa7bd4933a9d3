#include "dsp/fusion/interval/stereo_interval.h"

#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {

void stereo_interval(std::span<const Disparity> disparity, std::span<const std::uint8_t> half,
                     const DisparityTable& table, std::span<QuarterMm> low,
                     std::span<QuarterMm> high) noexcept {
  constexpr std::size_t kLanes = 8;
  STOF_CHECK(half.size() == disparity.size() && low.size() == disparity.size() &&
             high.size() == disparity.size());
  STOF_CHECK(table.size() >= 1 && table.bounds.size() <= 65536);
  if (table.bounds.size() > 32768) {  // twice their places would not fit u16
    ref::stereo_interval(disparity, half, table, low, high);
    return;
  }
  static_assert(sizeof(DepthInterval) == 2 * sizeof(QuarterMm));
  // Lows and highs in turn: places of numbers, not of pairs, need no instruction of their own.
  const QuarterMm* const lows =
      reinterpret_cast<const QuarterMm*>(table.bounds.data());  // NOLINT: two of them each
  const QuarterMm* const highs = lows + 1;
  const uint16x8_t last = vdupq_n_u16(static_cast<std::uint16_t>(table.size() - 1));
  const uint16x8_t middle = vdupq_n_u16(kMostHalfWidth);
  const int16x8_t first = vdupq_n_s16(table.first_raw);
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  std::size_t x = 0;
  for (; x + kLanes <= disparity.size(); x += kLanes) {
    const int16x8_t raw = vld1q_s16(&disparity[x].raw);
    const uint16x8_t step = vreinterpretq_u16_s16(vsubq_s16(raw, first));
    const uint16x8_t inside =
        vbicq_u16(vcleq_u16(step, last), vorrq_u16(vcltq_s16(raw, first), vceqq_s16(raw, none)));
    const uint16x8_t at = vaddq_u16(vandq_u16(step, inside), middle);
    const uint16x8_t half_width = vmovl_u8(vld1_u8(half.data() + x));
    std::array<std::uint16_t, kLanes> near{};
    std::array<std::uint16_t, kLanes> far{};
    vst1q_u16(near.data(), vshlq_n_u16(vaddq_u16(at, half_width), 1));
    vst1q_u16(far.data(), vshlq_n_u16(vsubq_u16(at, half_width), 1));
    for (std::size_t k = 0; k < kLanes; ++k) {  // NEON has no gather
      near[k] = lows[near[k]];
      far[k] = highs[far[k]];
    }
    const uint16x8_t begin = vld1q_u16(near.data());
    const uint16x8_t some = vandq_u16(inside, vcltq_u16(begin, vdupq_n_u16(table.max_range)));
    vst1q_u16(low.data() + x, vandq_u16(begin, some));
    vst1q_u16(high.data() + x, vandq_u16(vld1q_u16(far.data()), some));
  }
  ref::stereo_interval(disparity.subspan(x), half.subspan(x), table, low.subspan(x),
                       high.subspan(x));
}

}  // namespace stof::dsp::neon
