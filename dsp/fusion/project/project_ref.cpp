#include "dsp/fusion/project/project.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

std::int32_t along(QuarterMm distance, std::int16_t ray, std::int32_t origin) noexcept {
  return round_shift(std::int32_t{distance} * ray, kQ15Bits) + origin;
}

// Nearest integer, ties to even, of -2^20 <= v <= 2^20.
std::int32_t nearest_position(float v) noexcept {
  constexpr float kFar = kFarthestPosition;
  const float positive = std::clamp(v, -kFar, kFar) + kFar;
  return static_cast<std::int32_t>(positive + 12582912.0F) - 12582912 - kFarthestPosition;
}

}  // namespace

void project(const RayRow& rays, std::span<const QuarterMm> distance, const Projection& projection,
             std::span<std::int32_t> u, std::span<std::int32_t> v,
             std::span<QuarterMm> depth) noexcept {
  const std::size_t n = distance.size();
  STOF_CHECK(rays.x.size() == n && rays.y.size() == n && rays.z.size() == n);
  STOF_CHECK(u.size() == n && v.size() == n && depth.size() == n);
  for (std::size_t i = 0; i < n; ++i) {
    u[i] = 0;
    v[i] = 0;
    depth[i] = kNoDepth;
    const std::int32_t z = along(distance[i], rays.z[i], projection.origin[2]);
    if (distance[i] == kNoDepth || z <= 0) {
      continue;
    }
    const float x = static_cast<float>(along(distance[i], rays.x[i], projection.origin[0]));
    const float y = static_cast<float>(along(distance[i], rays.y[i], projection.origin[1]));
    const float range = static_cast<float>(z);
    u[i] = nearest_position(projection.focal_x * x / range + projection.centre_x);
    v[i] = nearest_position(projection.focal_y * y / range + projection.centre_y);
    depth[i] = static_cast<QuarterMm>(std::min<std::int32_t>(z, kMaxQuarterMm));
  }
}

}  // namespace stof::dsp::ref
