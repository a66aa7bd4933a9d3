#pragma once

#include <cmath>

#include "host/calibrate/rig/target/corner_finder.h"

namespace stof::host {

// Turns what a corner is off into what it is off in standard deviations of its own: the inverse of
// the Cholesky factor of its covariance.
struct Whitening {
  double uu = 1;
  double vu = 0;
  double vv = 1;

  template <typename T>
  void apply(T* off) const {
    off[1] = vu * off[0] + vv * off[1];
    off[0] = uu * off[0];
  }
};

// Of the covariance that the corner was found with times `scale`, and `floor` more in both
// coordinates, px^2.
inline Whitening whitening_of(const PixelPoint& corner, double scale, double floor) {
  const double first = std::sqrt(scale * corner.uu + floor);
  const double below = scale * corner.uv / first;
  const double second = std::sqrt(scale * corner.vv + floor - below * below);
  return {.uu = 1 / first, .vu = -below / (first * second), .vv = 1 / second};
}

}  // namespace stof::host
