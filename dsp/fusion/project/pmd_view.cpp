#include "dsp/fusion/project/pmd_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stof::dsp {
namespace {

// Of x^2 + y^2 at the corners of the picture, and a little more.
float widest_of(const Pinhole& lens) noexcept {
  constexpr double kMargin = 1.5;
  const double x = std::max(lens.cx, lens.width - lens.cx) / lens.fx;
  const double y = std::max(lens.cy, lens.height - lens.cy) / lens.fy;
  return static_cast<float>(kMargin * (x * x + y * y));
}

}  // namespace

PmdView::PmdView(const Calibration& calibration) noexcept {
  const Pinhole& left = calibration.stereo.left;
  const Pinhole& pmd = calibration.pmd.lens;
  const std::array<double, 9>& r = calibration.pmd_to_stereo.rotation;
  const std::array<double, 3>& t = calibration.pmd_to_stereo.translation_m;
  for (std::size_t k = 0; k < 3; ++k) {  // column k of R is row k of R^T
    const double rx = r[k];
    const double ry = r[3 + k];
    const double rz = r[6 + k];
    origin_[k] = static_cast<float>(rz - rx * left.cx / left.fx - ry * left.cy / left.fy);
    along_[k] = static_cast<float>(rx / left.fx);
    down_[k] = static_cast<float>(ry / left.fy);
    shift_[k] = static_cast<float>(kQuarterMmPerMetre * (rx * t[0] + ry * t[1] + rz * t[2]));
  }
  const auto f = [](double value) noexcept { return static_cast<float>(value); };
  lens_ = {.fx = f(pmd.fx),
           .fy = f(pmd.fy),
           .cx = f(pmd.cx),
           .cy = f(pmd.cy),
           .k1 = f(pmd.k1),
           .k2 = f(pmd.k2),
           .k3 = f(pmd.k3),
           .p1 = f(pmd.p1),
           .p2 = f(pmd.p2)};
  widest_ = widest_of(pmd);
  width_ = pmd.width;
  height_ = pmd.height;
}

PmdView::Place PmdView::of(int x, int y, float depth) const noexcept {
  std::array<float, 3> point;
  for (std::size_t k = 0; k < point.size(); ++k) {
    const float ray =
        origin_[k] + static_cast<float>(x) * along_[k] + static_cast<float>(y) * down_[k];
    point[k] = depth * ray - shift_[k];
  }
  if (point[2] <= 0) {
    return {};
  }
  const float u = point[0] / point[2];
  const float v = point[1] / point[2];
  const float r2 = u * u + v * v;
  if (r2 > widest_) {
    return {};
  }
  const float radial = 1 + r2 * (lens_.k1 + r2 * (lens_.k2 + r2 * lens_.k3));
  const float du = u * radial + 2 * lens_.p1 * u * v + lens_.p2 * (r2 + 2 * u * u);
  const float dv = v * radial + lens_.p1 * (r2 + 2 * v * v) + 2 * lens_.p2 * u * v;
  const float column = lens_.fx * du + lens_.cx + 0.5F;
  const float row = lens_.fy * dv + lens_.cy + 0.5F;
  if (column < 0 || row < 0 || column >= static_cast<float>(width_) ||
      row >= static_cast<float>(height_)) {
    return {};
  }
  return {static_cast<int>(column), static_cast<int>(row), point[2] * std::sqrt(1 + r2)};
}

}  // namespace stof::dsp
