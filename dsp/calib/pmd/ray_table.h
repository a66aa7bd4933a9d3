#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/calib/calibration.h"

namespace stof::dsp {

// Unit vector along which pixel (u, v) of a lens looks, the whole distortion of Pinhole removed by
// Newton's method. All zero where that does not come back to within 0.01 px of (u, v), or where
// the distortion has folded over on the way there: two directions show up at one place.
std::array<double, 3> unit_ray(const Pinhole& lens, double u, double v) noexcept;

// The unit rays of all pixels, row by row, as Q15 (32767 stands for +1). `turned` are R r, in the
// axes of the stereo camera; forward is r_z in the lens's own. Each has width x height elements.
struct RayTable {
  std::span<std::int16_t> turned_x;
  std::span<std::int16_t> turned_y;
  std::span<std::int16_t> turned_z;
  std::span<std::int16_t> forward;  // 0 = this pixel has no ray
};
void fill_ray_table(const Pinhole& lens, const std::array<double, 9>& rotation,
                    const RayTable& table) noexcept;
// The same in memory of an arena, from the PMD camera's axes to the left camera's.
RayTable make_ray_table(const Calibration& calibration, Arena& arena) noexcept;

}  // namespace stof::dsp
