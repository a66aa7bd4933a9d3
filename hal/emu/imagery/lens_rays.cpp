#include "hal/emu/imagery/lens_rays.h"

#include <algorithm>
#include <cmath>

namespace stof::hal::emu {
namespace {

constexpr double kExact = 1e-13;  // on the normalised plane
constexpr int kNewtonSteps = 60;

bool is_ideal(const dsp::Pinhole& lens) noexcept {
  return lens.k1 == 0 && lens.k2 == 0 && lens.k3 == 0 && lens.p1 == 0 && lens.p2 == 0;
}

// A place (x, y) of the normalised plane after distortion, and the derivatives of it.
struct Bent {
  double x = 0;
  double y = 0;
  double x_by_x = 1;
  double cross = 0;  // x by y, which is y by x
  double y_by_y = 1;
  double determinant() const noexcept { return x_by_x * y_by_y - cross * cross; }
};

Bent bend(const dsp::Pinhole& lens, double x, double y) noexcept {
  const double square = x * x + y * y;
  const double stretch = 1 + square * (lens.k1 + square * (lens.k2 + square * lens.k3));
  const double rate = 2 * (lens.k1 + square * (2 * lens.k2 + square * 3 * lens.k3));
  return {.x = x * stretch + 2 * lens.p1 * x * y + lens.p2 * (square + 2 * x * x),
          .y = y * stretch + lens.p1 * (square + 2 * y * y) + 2 * lens.p2 * x * y,
          .x_by_x = stretch + x * x * rate + 2 * lens.p1 * y + 6 * lens.p2 * x,
          .cross = x * y * rate + 2 * lens.p1 * x + 2 * lens.p2 * y,
          .y_by_y = stretch + y * y * rate + 6 * lens.p1 * y + 2 * lens.p2 * x};
}

double miss(const Bent& bent, double xd, double yd) noexcept {
  return std::abs(bent.x - xd) + std::abs(bent.y - yd);
}

// From (xd, yd) on, with steps that are halved until they come nearer.
Vec3 newton(const dsp::Pinhole& lens, double xd, double yd) noexcept {
  double x = xd;
  double y = yd;
  Bent now = bend(lens, x, y);
  for (int i = 0; i < kNewtonSteps && miss(now, xd, yd) > kExact; ++i) {
    const double det = now.determinant();
    const double ex = now.x - xd;
    const double ey = now.y - yd;
    const double dx = (now.y_by_y * ex - now.cross * ey) / det;
    const double dy = (now.x_by_x * ey - now.cross * ex) / det;
    double part = 1;
    Bent next = bend(lens, x - dx, y - dy);
    while (part > 1e-4 && !(miss(next, xd, yd) < miss(now, xd, yd))) {
      part /= 2;
      next = bend(lens, x - part * dx, y - part * dy);
    }
    if (!(miss(next, xd, yd) < miss(now, xd, yd))) {
      break;  // rounding, or a fold
    }
    x -= part * dx;
    y -= part * dy;
    now = next;
  }
  return {x, y, 1};
}

}  // namespace

PicturePoint project(const dsp::Pinhole& lens, double x, double y) noexcept {
  const Bent bent = bend(lens, x, y);
  return {.u = lens.fx * bent.x + lens.cx, .v = lens.fy * bent.y + lens.cy};
}

Vec3 undistorted_ray(const dsp::Pinhole& lens, double u, double v) noexcept {
  const double xd = (u - lens.cx) / lens.fx;
  const double yd = (v - lens.cy) / lens.fy;
  if (is_ideal(lens)) {
    return {xd, yd, 1};
  }
  constexpr int kSteps = 20;  // each gains a digit or more for |k1 r^2| < 0.1
  double x = xd;
  double y = yd;
  for (int i = 0; i < kSteps; ++i) {
    const double square = x * x + y * y;
    const double stretch = 1 + square * (lens.k1 + square * (lens.k2 + square * lens.k3));
    const double dx = 2 * lens.p1 * x * y + lens.p2 * (square + 2 * x * x);
    const double dy = lens.p1 * (square + 2 * y * y) + 2 * lens.p2 * x * y;
    x = (xd - dx) / stretch;
    y = (yd - dy) / stretch;
  }
  // Stronger lenses need more; a start that did not come near is of no use.
  return miss(bend(lens, x, y), xd, yd) <= kExact ? Vec3{x, y, 1} : newton(lens, xd, yd);
}

bool shows_each_place_once(const dsp::Pinhole& lens) noexcept {
  constexpr double kBeyond = 2;
  constexpr double kSame = 1e-9;  // px
  constexpr int kProbes = 32;     // a side, and on the way out
  for (int j = 0; j <= kProbes; ++j) {
    for (int i = 0; i <= kProbes; ++i) {
      const double u = -kBeyond + (lens.width - 1 + 2 * kBeyond) * i / kProbes;
      const double v = -kBeyond + (lens.height - 1 + 2 * kBeyond) * j / kProbes;
      const Vec3 ray = undistorted_ray(lens, u, v);
      const PicturePoint back = project(lens, ray.x, ray.y);
      if (!(std::abs(back.u - u) <= kSame) || !(std::abs(back.v - v) <= kSame)) {
        return false;
      }
      for (int k = 0; k <= kProbes; ++k) {
        const double part = static_cast<double>(k) / kProbes;
        if (!(bend(lens, part * ray.x, part * ray.y).determinant() > 0)) {
          return false;
        }
      }
    }
  }
  return true;
}

LensRays::LensRays(const dsp::Pinhole& lens) : lens_(lens) {
  if (is_ideal(lens)) {
    return;
  }
  centres_.reserve(static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height));
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      centres_.push_back(undistorted_ray(lens, x, y));
    }
  }
}

Vec3 LensRays::beside(int x, int y, double du, double dv) const noexcept {
  const Vec3& centre =
      centres_[static_cast<std::size_t>(y) * static_cast<std::size_t>(lens_.width) +
               static_cast<std::size_t>(x)];
  const Bent bent = bend(lens_, centre.x, centre.y);
  const double det = bent.determinant();
  const double a = du / lens_.fx;
  const double b = dv / lens_.fy;
  return {centre.x + (bent.y_by_y * a - bent.cross * b) / det,
          centre.y + (bent.x_by_x * b - bent.cross * a) / det, 1};
}

Vec3 LensRays::near(double u, double v) const noexcept {
  const int x = std::clamp(static_cast<int>(std::floor(u + 0.5)), 0, lens_.width - 1);
  const int y = std::clamp(static_cast<int>(std::floor(v + 0.5)), 0, lens_.height - 1);
  return beside(x, y, u - x, v - y);
}

Viewpoint::Window LensRays::window(int x, int y) const noexcept {
  if (centres_.empty()) {
    return {.x_min = (x - 0.5 - lens_.cx) / lens_.fx,
            .x_max = (x + 0.5 - lens_.cx) / lens_.fx,
            .y_min = (y - 0.5 - lens_.cy) / lens_.fy,
            .y_max = (y + 0.5 - lens_.cy) / lens_.fy};
  }
  const Vec3 first = beside(x, y, -0.5, -0.5);
  Viewpoint::Window out{first.x, first.x, first.y, first.y};
  for (const Vec3& corner :
       {beside(x, y, 0.5, -0.5), beside(x, y, -0.5, 0.5), beside(x, y, 0.5, 0.5)}) {
    out.x_min = std::min(out.x_min, corner.x);
    out.x_max = std::max(out.x_max, corner.x);
    out.y_min = std::min(out.y_min, corner.y);
    out.y_max = std::max(out.y_max, corner.y);
  }
  return out;
}

}  // namespace stof::hal::emu
