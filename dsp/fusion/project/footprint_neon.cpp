#include "dsp/fusion/project/footprint.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 4;
constexpr std::size_t kNarrowLanes = 8;

int32x4_t half_size(float32x4_t ratio, float scale, int32x4_t some) noexcept {
  constexpr float kFar = kFarthestPosition;
  const float32x4_t half =
      vaddq_f32(vmulq_f32(vdupq_n_f32(scale), ratio), vdupq_n_f32(kFootprintMargin));
  const int32x4_t whole = vcvtq_s32_f32(vminq_f32(half, vdupq_n_f32(kFar)));
  return vornq_s32(whole, some);  // all bits set are kNoFootprint
}

// Of 1/16 px, rounded down, to pixels 0 .. size.
int16x4_t pixel(int32x4_t place, int size) noexcept {
  const int32x4_t down = vshrq_n_s32(place, kPositionBits);
  return vmovn_s32(vmaxq_s32(vminq_s32(down, vdupq_n_s32(size)), vdupq_n_s32(0)));
}

struct Bounds {
  int16x4_t begin;
  int16x4_t end;
};
Bounds bounds(const std::int32_t* place, const std::int32_t* half, int size) noexcept {
  const int32x4_t at = vld1q_s32(place);
  const int32x4_t reach = vld1q_s32(half);
  return {pixel(vaddq_s32(vsubq_s32(at, reach), vdupq_n_s32(kPositionOne - 1)), size),
          pixel(vaddq_s32(vaddq_s32(at, reach), vdupq_n_s32(kPositionOne)), size)};
}

}  // namespace

void half_sizes(std::span<const QuarterMm> distance, std::span<const std::int16_t> forward,
                std::span<const QuarterMm> depth, const FootprintScale& scale,
                std::span<std::int32_t> half_x, std::span<std::int32_t> half_y) noexcept {
  static_assert(kNoFootprint == -1);
  const std::size_t n = distance.size();
  STOF_CHECK(forward.size() == n && depth.size() == n && half_x.size() == n && half_y.size() == n);
  const int32x4_t one = vdupq_n_s32(1);
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    const int32x4_t d = vreinterpretq_s32_u32(vmovl_u16(vld1_u16(distance.data() + i)));
    const int32x4_t f = vmovl_s16(vld1_s16(forward.data() + i));
    const int32x4_t z = vreinterpretq_s32_u32(vmovl_u16(vld1_u16(depth.data() + i)));
    const int32x4_t some = vreinterpretq_s32_u32(vcgeq_s32(vminq_s32(vminq_s32(d, z), f), one));
    // Lanes without a reading divide by 1 and are masked.
    const float32x4_t along = vmulq_f32(vcvtq_f32_s32(d), vcvtq_f32_s32(vmaxq_s32(f, one)));
    const float32x4_t ratio = simd::divide(along, vcvtq_f32_s32(vmaxq_s32(z, one)));
    vst1q_s32(half_x.data() + i, half_size(ratio, scale.x, some));
    vst1q_s32(half_y.data() + i, half_size(ratio, scale.y, some));
  }
  ref::half_sizes(distance.subspan(i), forward.subspan(i), depth.subspan(i), scale,
                  half_x.subspan(i), half_y.subspan(i));
}

void footprint_ranges(std::span<const std::int32_t> place, std::span<const std::int32_t> half,
                      int size, std::span<std::int16_t> begin,
                      std::span<std::int16_t> end) noexcept {
  const std::size_t n = place.size();
  STOF_CHECK(half.size() == n && begin.size() == n && end.size() == n);
  std::size_t i = 0;
  for (; i + kNarrowLanes <= n; i += kNarrowLanes) {
    const Bounds left = bounds(place.data() + i, half.data() + i, size);
    const Bounds right = bounds(place.data() + i + kLanes, half.data() + i + kLanes, size);
    vst1q_s16(begin.data() + i, vcombine_s16(left.begin, right.begin));
    vst1q_s16(end.data() + i, vcombine_s16(left.end, right.end));
  }
  ref::footprint_ranges(place.subspan(i), half.subspan(i), size, begin.subspan(i), end.subspan(i));
}

}  // namespace stof::dsp::neon
