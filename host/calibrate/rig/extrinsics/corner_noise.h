#pragma once

#include <vector>

#include "host/calibrate/rig/target/corner_finder.h"

namespace stof::host {

// How far corners of one kind of camera scatter: by the covariances that they were found with times
// `scale`, and by `floor` more in each coordinate, px^2, which is what lens, print and flatness
// leave, the same for all.
struct CornerNoise {
  double scale = 1;
  double floor = 0.01;
};

// The variance components of what corners are off, by maximum likelihood, as if off were
// independent. `freedom`: the share of the coordinates that unknowns have left. A corner that is
// off by more than three standard deviations counts as if by three.
struct CornerOff {
  PixelPoint found;  // with its covariance
  double u = 0;      // off, px
  double v = 0;
};
CornerNoise corner_noise(const std::vector<CornerOff>& corners, double freedom,
                         const CornerNoise& start);

}  // namespace stof::host
