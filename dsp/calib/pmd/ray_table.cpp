#include "dsp/calib/pmd/ray_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/fixed.h"
#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr int kIterations = 50;
constexpr double kConverged = 1e-12;  // on the normalised plane
constexpr double kLargestErrorPx = 0.01;
constexpr int kFoldSteps = 64;

struct Point {
  double x = 0;
  double y = 0;
};

// Brown's model at a point, and how it changes with the point.
struct Bent {
  Point at;
  double dx_dx = 0;
  double dx_dy = 0;
  double dy_dx = 0;
  double dy_dy = 0;
  double determinant() const noexcept { return dx_dx * dy_dy - dx_dy * dy_dx; }
};

Bent bend(const Pinhole& lens, const Point& p) noexcept {
  const double r2 = p.x * p.x + p.y * p.y;
  const double s = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double slope = lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3);  // ds / d(r^2)
  const double across = 2 * p.x * p.y * slope + 2 * lens.p1 * p.x + 2 * lens.p2 * p.y;
  return {.at = {p.x * s + 2 * lens.p1 * p.x * p.y + lens.p2 * (r2 + 2 * p.x * p.x),
                 p.y * s + lens.p1 * (r2 + 2 * p.y * p.y) + 2 * lens.p2 * p.x * p.y},
          .dx_dx = s + 2 * p.x * p.x * slope + 2 * lens.p1 * p.y + 6 * lens.p2 * p.x,
          .dx_dy = across,
          .dy_dx = across,
          .dy_dy = s + 2 * p.y * p.y * slope + 6 * lens.p1 * p.y + 2 * lens.p2 * p.x};
}

// Whether the radius of the picture grows with that of the scene all the way out to r.
bool grows_up_to(const Pinhole& lens, double r) noexcept {
  for (int i = 0; i <= kFoldSteps; ++i) {
    const double part = r * i / kFoldSteps;
    const double r2 = part * part;
    if (!(1 + r2 * (3 * lens.k1 + r2 * (5 * lens.k2 + r2 * 7 * lens.k3)) > 0)) {
      return false;
    }
  }
  return true;
}

// The point that bends to `wanted`, by Newton's method with steps halved until they help.
Point straighten(const Pinhole& lens, const Point& wanted) noexcept {
  Point p = wanted;
  Bent now = bend(lens, p);
  double miss = std::hypot(now.at.x - wanted.x, now.at.y - wanted.y);
  for (int i = 0; i < kIterations && miss > kConverged; ++i) {
    const double det = now.determinant();
    if (!(std::abs(det) > kConverged)) {
      break;
    }
    const double ex = now.at.x - wanted.x;
    const double ey = now.at.y - wanted.y;
    const Point step{(now.dy_dy * ex - now.dx_dy * ey) / det,
                     (now.dx_dx * ey - now.dy_dx * ex) / det};
    bool better = false;
    for (double part = 1; part > 1e-3 && !better; part /= 2) {
      const Point next{p.x - part * step.x, p.y - part * step.y};
      const Bent there = bend(lens, next);
      const double missed = std::hypot(there.at.x - wanted.x, there.at.y - wanted.y);
      better = missed < miss;
      if (better) {
        p = next;
        now = there;
        miss = missed;
      }
    }
    if (!better) {
      break;
    }
  }
  return p;
}

std::int16_t to_q15(double value) noexcept {
  const double scaled = std::round(value * kQ15One);
  return static_cast<std::int16_t>(std::clamp(scaled, -32767.0, 32767.0));
}

}  // namespace

std::array<double, 3> unit_ray(const Pinhole& lens, double u, double v) noexcept {
  const Point wanted{(u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy};
  const Point p = straighten(lens, wanted);
  const Bent found = bend(lens, p);
  const double error =
      std::hypot((found.at.x - wanted.x) * lens.fx, (found.at.y - wanted.y) * lens.fy);
  if (!(error <= kLargestErrorPx) || !(found.determinant() > 0) ||
      !grows_up_to(lens, std::hypot(p.x, p.y))) {
    return {};
  }
  const double length = std::sqrt(p.x * p.x + p.y * p.y + 1);
  return {p.x / length, p.y / length, 1 / length};
}

void fill_ray_table(const Pinhole& lens, const std::array<double, 9>& rotation,
                    const RayTable& table) noexcept {
  const std::size_t count = pixel_count(lens.width, lens.height);
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

RayTable make_ray_table(const Calibration& calibration, Arena& arena) noexcept {
  const Pinhole& lens = calibration.pmd.lens;
  const std::size_t count = pixel_count(lens.width, lens.height);
  const RayTable table{arena.take<std::int16_t>(count), arena.take<std::int16_t>(count),
                       arena.take<std::int16_t>(count), arena.take<std::int16_t>(count)};
  if (!arena.is_measuring()) {
    fill_ray_table(lens, calibration.pmd_to_stereo.rotation, table);
  }
  return table;
}

}  // namespace stof::dsp
