#include "dsp/fusion/project/project.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kLanes = 8;

__m128i eight(const void* p) noexcept { return _mm_loadu_si128(static_cast<const __m128i*>(p)); }

i32x8 along(i32x8 distance, const std::int16_t* ray, std::int32_t origin) noexcept {
  const i32x8 way = distance * as<i32x8>(_mm256_cvtepi16_epi32(eight(ray)));
  return ((way + all(std::int32_t{kQ15One / 2})) >> kQ15Bits) + all(origin);
}

__m256 all_of(float v) noexcept { return _mm256_set1_ps(v); }

i32x8 position(i32x8 across, __m256 range, float focal, float centre) noexcept {
  constexpr float kFar = kFarthestPosition;
  const __m256 tangent =
      _mm256_div_ps(_mm256_mul_ps(all_of(focal), _mm256_cvtepi32_ps(bits(across))), range);
  const __m256 place = _mm256_add_ps(tangent, all_of(centre));
  const __m256 limited = _mm256_min_ps(_mm256_max_ps(place, all_of(-kFar)), all_of(kFar));
  // Nearest, ties to even: how the processor rounds unless it is told otherwise.
  return as<i32x8>(_mm256_cvtps_epi32(_mm256_add_ps(limited, all_of(kFar)))) -
         all(kFarthestPosition);
}

}  // namespace

void project(const RayRow& rays, std::span<const QuarterMm> distance, const Projection& projection,
             std::span<std::int32_t> u, std::span<std::int32_t> v,
             std::span<QuarterMm> depth) noexcept {
  const std::size_t n = distance.size();
  STOF_CHECK(rays.x.size() == n && rays.y.size() == n && rays.z.size() == n);
  STOF_CHECK(u.size() == n && v.size() == n && depth.size() == n);
  const __m256i zero = _mm256_setzero_si256();
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    const __m128i some = eight(&distance[i]);
    i32x8 out_u = as<i32x8>(zero);
    i32x8 out_v = out_u;
    __m256i deep = zero;
    if (_mm_testz_si128(some, some) == 0) {  // often there is nothing in a whole vector
      const i32x8 d = as<i32x8>(_mm256_cvtepu16_epi32(some));
      const i32x8 x = along(d, &rays.x[i], projection.origin[0]);
      const i32x8 y = along(d, &rays.y[i], projection.origin[1]);
      const i32x8 z = along(d, &rays.z[i], projection.origin[2]);
      const __m256i seen =
          _mm256_and_si256(_mm256_cmpgt_epi32(bits(d), zero), _mm256_cmpgt_epi32(bits(z), zero));
      // Lanes behind the camera divide by 1 and are masked.
      const __m256 range = _mm256_cvtepi32_ps(_mm256_max_epi32(bits(z), _mm256_set1_epi32(1)));
      out_u = position(x, range, projection.focal_x, projection.centre_x) & as<i32x8>(seen);
      out_v = position(y, range, projection.focal_y, projection.centre_y) & as<i32x8>(seen);
      deep = _mm256_and_si256(bits(z), seen);
    }
    store(&u[i], out_u);
    store(&v[i], out_v);
    store_half(&depth[i],
               as<u16x16>(_mm256_permute4x64_epi64(_mm256_packus_epi32(deep, deep), 0xD8)));
  }
  ref::project({rays.x.subspan(i), rays.y.subspan(i), rays.z.subspan(i)}, distance.subspan(i),
               projection, u.subspan(i), v.subspan(i), depth.subspan(i));
}

}  // namespace stof::dsp::avx2
