#include "dsp/fusion/project/project.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 4;
constexpr std::int32_t kHalf = kQ15One / 2;

int32x4_t along(int32x4_t distance, const std::int16_t* ray, std::int32_t origin) noexcept {
  // The sum stays below 2^31: rounding by a shift would cost other processors than ARM an addition.
  const int32x4_t way = vmlaq_s32(vdupq_n_s32(kHalf), distance, vmovl_s16(vld1_s16(ray)));
  return vaddq_s32(vshrq_n_s32(way, kQ15Bits), vdupq_n_s32(origin));
}

int32x4_t position(float32x4_t across, float32x4_t range, float focal, float centre) noexcept {
  constexpr float kFar = kFarthestPosition;
  const float32x4_t far = vdupq_n_f32(kFar);
  const float32x4_t tangent = simd::divide(vmulq_f32(vdupq_n_f32(focal), across), range);
  const float32x4_t place = vaddq_f32(tangent, vdupq_n_f32(centre));
  const float32x4_t limited = vminq_f32(vmaxq_f32(place, vnegq_f32(far)), far);
  return vsubq_s32(simd::round_to_int(vaddq_f32(limited, far)), vdupq_n_s32(kFarthestPosition));
}

}  // namespace

void project(const RayRow& rays, std::span<const QuarterMm> distance, const Projection& projection,
             std::span<std::int32_t> u, std::span<std::int32_t> v,
             std::span<QuarterMm> depth) noexcept {
  const std::size_t n = distance.size();
  STOF_CHECK(rays.x.size() == n && rays.y.size() == n && rays.z.size() == n);
  STOF_CHECK(u.size() == n && v.size() == n && depth.size() == n);
  const int32x4_t zero = vdupq_n_s32(0);
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    const int32x4_t d = vreinterpretq_s32_u32(vmovl_u16(vld1_u16(distance.data() + i)));
    const int32x4_t x = along(d, rays.x.data() + i, projection.origin[0]);
    const int32x4_t y = along(d, rays.y.data() + i, projection.origin[1]);
    const int32x4_t z = along(d, rays.z.data() + i, projection.origin[2]);
    const int32x4_t seen = vreinterpretq_s32_u32(vandq_u32(vcgtq_s32(d, zero), vcgtq_s32(z, zero)));
    // Lanes behind the camera divide by 1 and are masked.
    const float32x4_t range = vcvtq_f32_s32(vmaxq_s32(z, vdupq_n_s32(1)));
    vst1q_s32(u.data() + i, vandq_s32(seen, position(vcvtq_f32_s32(x), range, projection.focal_x,
                                                     projection.centre_x)));
    vst1q_s32(v.data() + i, vandq_s32(seen, position(vcvtq_f32_s32(y), range, projection.focal_y,
                                                     projection.centre_y)));
    vst1_u16(depth.data() + i, vqmovun_s32(vandq_s32(seen, z)));
  }
  ref::project({rays.x.subspan(i), rays.y.subspan(i), rays.z.subspan(i)}, distance.subspan(i),
               projection, u.subspan(i), v.subspan(i), depth.subspan(i));
}

}  // namespace stof::dsp::neon
