#include "dsp/fusion/temporal/pixel_change.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

bool any(uint8x16_t mask) noexcept {
  const uint64x2_t words = vreinterpretq_u64_u8(mask);
  return (vgetq_lane_u64(words, 0) | vgetq_lane_u64(words, 1)) != 0;
}

}  // namespace

void pixel_change(std::span<const std::uint8_t> now, std::span<std::uint8_t> then,
                  std::span<std::uint8_t> changed) noexcept {
  STOF_CHECK(now.size() == changed.size() && then.size() == changed.size());
  constexpr std::size_t kLanes = 16;
  std::size_t x = 0;
  for (; x + kLanes <= changed.size(); x += kLanes) {
    const uint8x16_t here = vld1q_u8(now.data() + x);
    const uint8x16_t before = vld1q_u8(then.data() + x);
    const uint8x16_t differs = vcgtq_u8(vabdq_u8(here, before), vdupq_n_u8(kPixelStep));
    vst1q_u8(changed.data() + x, differs);
    if (any(differs)) {  // most stay as they are
      vst1q_u8(then.data() + x, vbslq_u8(differs, here, before));
    }
  }
  ref::pixel_change(now.subspan(x), then.subspan(x), changed.subspan(x));
}

}  // namespace stof::dsp::neon
