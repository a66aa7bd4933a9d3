#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"

namespace stof::dsp {

// Positions in the left image in 1/16 px.
inline constexpr int kPositionBits = 4;
inline constexpr int kPositionOne = 1 << kPositionBits;
// Positions are clamped to +-65536 px.
inline constexpr std::int32_t kFarthestPosition = 1 << 20;

// X_stereo = ray * distance + origin, then u = focal X / Z + centre.
struct Projection {
  std::array<std::int32_t, 3> origin{};  // the PMD camera in the axes of the left camera, quarter
                                         // mm, each within +-400,000
  float focal_x = 1;                     // 1/16 px
  float focal_y = 1;
  float centre_x = 0;
  float centre_y = 0;
};

// Rays of a row of PMD pixels in the axes of the left camera, Q15.
struct RayRow {
  std::span<const std::int16_t> x;
  std::span<const std::int16_t> y;
  std::span<const std::int16_t> z;
};

// Where points seen by a row of PMD pixels lie in the left view:
//   X = origin + ((distance * ray + 16384) >> 15), quarter mm, for all three axes
//   u = focal_x * X / Z + centre_x by IEEE single operations in that order, clamped, to whole 1/16
//   px:
//       2^20 is added for that, which leaves 1/8 of a step; so at most 0.57 steps off; v alike
//   depth = Z, saturated to u16
// Where distance is 0 or Z is not positive (behind the camera): u = v = depth = 0.
// Equal lengths, any length, any alignment; no overlap.
using ProjectKernel = void(const RayRow& rays, std::span<const QuarterMm> distance,
                           const Projection& projection, std::span<std::int32_t> u,
                           std::span<std::int32_t> v, std::span<QuarterMm> depth) noexcept;
STOF_KERNEL(ProjectKernel, project, kAvx2)

}  // namespace stof::dsp
