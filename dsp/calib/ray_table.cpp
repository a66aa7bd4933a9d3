#include "dsp/calib/ray_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"

namespace stof::dsp {
namespace {

constexpr int kIterations = 20;
constexpr double kLargestErrorPx = 0.01;

double stretch(const Pinhole& lens, double x, double y) noexcept {
  const double r2 = x * x + y * y;
  return 1 + r2 * (lens.k1 + r2 * lens.k2);
}

std::int16_t to_q15(double value) noexcept {
  const double scaled = std::round(value * kQ15One);
  return static_cast<std::int16_t>(std::clamp(scaled, -32767.0, 32767.0));
}

}  // namespace

std::array<double, 3> unit_ray(const Pinhole& lens, double u, double v) noexcept {
  const double bent_x = (u - lens.cx) / lens.fx;
  const double bent_y = (v - lens.cy) / lens.fy;
  double x = bent_x;
  double y = bent_y;
  for (int i = 0; i < kIterations; ++i) {
    const double s = stretch(lens, x, y);
    x = bent_x / s;
    y = bent_y / s;
  }
  const double s = stretch(lens, x, y);
  const double error = std::hypot((x * s - bent_x) * lens.fx, (y * s - bent_y) * lens.fy);
  if (!(s > 0) || !(error <= kLargestErrorPx)) {
    return {};
  }
  const double length = std::sqrt(x * x + y * y + 1);
  return {x / length, y / length, 1 / length};
}

void fill_ray_table(const Pinhole& lens, const std::array<double, 9>& rotation,
                    const RayTable& table) noexcept {
  const std::size_t count =
      static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height);
  STOF_CHECK(table.turned_x.size() == count && table.turned_y.size() == count);
  STOF_CHECK(table.turned_z.size() == count && table.forward.size() == count);
  std::size_t i = 0;
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u, ++i) {
      const std::array<double, 3> ray = unit_ray(lens, u, v);
      std::array<double, 3> turned{};
      for (std::size_t k = 0; k < 3; ++k) {
        turned[k] =
            rotation[3 * k] * ray[0] + rotation[3 * k + 1] * ray[1] + rotation[3 * k + 2] * ray[2];
      }
      table.turned_x[i] = to_q15(turned[0]);
      table.turned_y[i] = to_q15(turned[1]);
      table.turned_z[i] = to_q15(turned[2]);
      table.forward[i] = to_q15(ray[2]);
    }
  }
}

}  // namespace stof::dsp
