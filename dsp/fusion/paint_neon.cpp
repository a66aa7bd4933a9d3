#include "dsp/fusion/paint.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {

namespace {
constexpr std::size_t kLanes = 8;
}

void paint_nearest(QuarterMm depth, std::span<QuarterMm> nearest) noexcept {
  const uint16x8_t all = vdupq_n_u16(depth);
  std::size_t x = 0;
  for (; x + kLanes <= nearest.size(); x += kLanes) {
    vst1q_u16(nearest.data() + x, vminq_u16(vld1q_u16(nearest.data() + x), all));
  }
  ref::paint_nearest(depth, nearest.subspan(x));
}

void paint_interval(const Paint& paint, std::span<const QuarterMm> nearest,
                    std::span<QuarterMm> low, std::span<QuarterMm> high,
                    std::span<std::uint8_t> flags) noexcept {
  const std::size_t n = nearest.size();
  STOF_CHECK(low.size() == n && high.size() == n && flags.size() == n);
  const uint16x8_t visible = vdupq_n_u16(paint.visible);
  const uint16x8_t lo = vdupq_n_u16(paint.low);
  const uint16x8_t hi = vdupq_n_u16(paint.high);
  const uint8x8_t bits = vdup_n_u8(paint.flags);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const uint16x8_t seen = vcgeq_u16(vld1q_u16(nearest.data() + x), visible);
    // Where another surface hides this one: lo becomes the largest number, hi the smallest.
    const uint16x8_t from = vornq_u16(lo, seen);
    const uint16x8_t to = vandq_u16(hi, seen);
    vst1q_u16(low.data() + x, vminq_u16(vld1q_u16(low.data() + x), from));
    vst1q_u16(high.data() + x, vmaxq_u16(vld1q_u16(high.data() + x), to));
    const uint8x8_t marks = vand_u8(bits, vmovn_u16(seen));
    vst1_u8(flags.data() + x, vorr_u8(vld1_u8(flags.data() + x), marks));
  }
  ref::paint_interval(paint, nearest.subspan(x), low.subspan(x), high.subspan(x), flags.subspan(x));
}

}  // namespace stof::dsp::neon
