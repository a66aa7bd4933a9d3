#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "dsp/calib/calibration.h"

// The chapter's rig, whose axes converge (dsp::Converging), as five unknowns.
namespace stof::host {

inline constexpr std::size_t kPlaneUnknowns = 5;
// b (m), alpha, beta (rad), f1, f2 (m).
using PlaneUnknowns = std::array<double, kPlaneUnknowns>;
inline constexpr std::array<const char*, kPlaneUnknowns> kPlaneNames{"b", "alpha", "beta", "f1",
                                                                     "f2"};

// Columns of both pictures, counted from their principal columns, as tangents of a lens of 1 m:
// -x u. Where both look: parallax T_r - T_l of the formula of dsp::Converging, Z = b / parallax.
template <typename T>
T tangent_of(const T& yaw_tangent, const T& ray) {
  return (yaw_tangent + ray) / (T(1) - yaw_tangent * ray);
}
template <typename T>
T parallax_of(const T* x, double left_m, double right_m) {
  using std::tan;
  return tangent_of(tan(x[1]), T(-right_m) / x[3]) - tangent_of(tan(x[2]), T(-left_m) / x[4]);
}
template <typename T>
T depth_of(const T* x, double left_m, double right_m) {
  return x[0] / parallax_of(x, left_m, right_m);
}

// b F cos^2(alpha), which disparities tell best: F and alpha are means of both cameras. m^2.
double triangulation_constant(const PlaneUnknowns& x);
// Where the axes meet, from the baseline; infinite where they do not.
double zero_disparity_m(const PlaneUnknowns& x);

// The chapter's own result (Table 2), pixels of 5.6 um.
inline constexpr PlaneUnknowns kTable2{0.0024691, 0.3045662, 0.3041429, 0.7583599, 0.7580368};
inline constexpr double kTable2PixelM = 5.6e-6;

}  // namespace stof::host
