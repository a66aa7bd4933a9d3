#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/calib/stereo/rectification.h"

// A textured plane before two cameras that are turned against each other and bend their pictures.
namespace stof::dsp::raw {

using Vec = std::array<double, 3>;

inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec times(const std::array<double, 9>& m, const Vec& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}
inline Vec times_transposed(const std::array<double, 9>& m, const Vec& v) {
  return {m[0] * v[0] + m[3] * v[1] + m[6] * v[2], m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
          m[2] * v[0] + m[5] * v[1] + m[8] * v[2]};
}

// Turns by x, then y, then z, in radians.
inline std::array<double, 9> turned(double x, double y, double z) {
  const double cx = std::cos(x), sx = std::sin(x), cy = std::cos(y), sy = std::sin(y);
  const double cz = std::cos(z), sz = std::sin(z);
  return {cz * cy,
          cz * sy * sx - sz * cx,
          cz * sy * cx + sz * sx,
          sz * cy,
          sz * sy * sx + cz * cx,
          sz * sy * cx - cz * sx,
          -sy,
          cy * sx,
          cy * cx};
}

// A few degrees of everything, two lenses that differ, 12 cm apart. toe_in_rad: of both together.
inline RawPair raw_pair(int width, int height, double toe_in_rad = 0.03) {
  const double f = 0.9 * width;
  RawPair pair;
  pair.left = {.width = width,
               .height = height,
               .fx = f,
               .fy = f * 1.002,
               .cx = width * 0.51,
               .cy = height * 0.48,
               .k1 = -0.24,
               .k2 = 0.07};
  pair.right = {.width = width,
                .height = height,
                .fx = f * 1.01,
                .fy = f * 1.011,
                .cx = width * 0.492,
                .cy = height * 0.515,
                .k1 = -0.21,
                .k2 = 0.05};
  pair.left_to_right.rotation = turned(0.015, toe_in_rad, -0.02);
  pair.left_to_right.translation_m = {-0.12, 0.004, 0.006};
  return pair;
}

// Points of the plane in the left camera's axes: normal . X = away_m.
struct Plane {
  Vec normal{0.05, -0.08, 1};
  double away_m = 1.5;

  Vec meet(const Vec& origin, const Vec& direction) const {
    const double s = (away_m - dot(normal, origin)) / dot(normal, direction);
    return {origin[0] + s * direction[0], origin[1] + s * direction[1],
            origin[2] + s * direction[2]};
  }
};

// Waves of many directions, none shorter than `shortest_m`; 128 +- 110 grey levels.
inline double texture(const Vec& point, double shortest_m) {
  double sum = 0;
  for (int i = 0; i < 14; ++i) {
    const double along = 2.4 * i + 0.3;
    const double wave = shortest_m * (1 + 0.37 * i);
    const double way = point[0] * std::cos(along) + point[1] * std::sin(along);
    sum += std::sin(2 * std::numbers::pi * way / wave + 1.7 * i * i);
  }
  return std::clamp(128 + 30 * sum, 18.0, 238.0);
}

// Where a raw camera sees the plane at pixel (u, v), in the left camera's axes.
inline Vec seen_by_left(const RawPair& pair, const Plane& plane, double u, double v) {
  return plane.meet({}, unit_ray(pair.left, u, v));
}
inline Vec seen_by_right(const RawPair& pair, const Plane& plane, double u, double v) {
  const std::array<double, 9>& r = pair.left_to_right.rotation;
  Vec centre = times_transposed(r, pair.left_to_right.translation_m);
  centre = {-centre[0], -centre[1], -centre[2]};
  return plane.meet(centre, times_transposed(r, unit_ray(pair.right, u, v)));
}

// Raw pixel of a point in the camera's own axes.
inline std::array<double, 2> project(const Pinhole& lens, const Vec& p) {
  const double x = p[0] / p[2];
  const double y = p[1] / p[2];
  const double r2 = x * x + y * y;
  const double bend = 1 + lens.k1 * r2 + lens.k2 * r2 * r2;
  return {lens.fx * x * bend + lens.cx, lens.fy * y * bend + lens.cy};
}
inline Vec to_right_camera(const RawPair& pair, const Vec& point) {
  const Vec p = times(pair.left_to_right.rotation, point);
  const Vec& t = pair.left_to_right.translation_m;
  return {p[0] + t[0], p[1] + t[1], p[2] + t[2]};
}

// The point of the plane behind pixel (u, v) of the rectified left picture, in the left camera's
// axes, and its Z in the rectified ones.
struct Behind {
  Vec point;
  double z = 0;
};
inline Behind behind_rectified(const Rectification& rectified, const Plane& plane, double u,
                               double v) {
  const Pinhole& lens = rectified.left;
  const Vec ray{(u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy, 1};
  Behind behind;
  behind.point = plane.meet({}, times_transposed(rectified.left_turn, ray));
  behind.z = times(rectified.left_turn, behind.point)[2];
  return behind;
}

template <typename Seen>
void render(const ImageView<std::uint8_t>& out, double shortest_m, Seen seen) {
  for (int v = 0; v < out.height(); ++v) {
    for (int u = 0; u < out.width(); ++u) {
      out.at(u, v) = static_cast<std::uint8_t>(std::lround(texture(seen(u, v), shortest_m)));
    }
  }
}

}  // namespace stof::dsp::raw
