#include "dsp/fusion/project/projection.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "dsp/base/index.h"

namespace stof::dsp {

Projection projection_of(const Calibration& calibration) noexcept {
  const Pinhole& left = calibration.stereo.left;
  Projection out;
  for (std::size_t k = 0; k < out.origin.size(); ++k) {
    out.origin[k] = static_cast<std::int32_t>(
        std::lround(calibration.pmd_to_stereo.translation_m[k] * kQuarterMmPerMetre));
  }
  out.focal_x = static_cast<float>(left.fx * kPositionOne);
  out.focal_y = static_cast<float>(left.fy * kPositionOne);
  out.centre_x = static_cast<float>(left.cx * kPositionOne);
  out.centre_y = static_cast<float>(left.cy * kPositionOne);
  return out;
}

RayRow ray_row(const RayTable& rays, int width, int y) noexcept {
  const std::size_t first = pixel_count(width, y);
  const std::size_t n = index(width);
  return {rays.turned_x.subspan(first, n), rays.turned_y.subspan(first, n),
          rays.turned_z.subspan(first, n)};
}

}  // namespace stof::dsp
