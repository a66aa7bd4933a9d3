#include "host/calibrate/rig/planes/converging_model.h"

#include <cmath>
#include <limits>

namespace stof::host {

double triangulation_constant(const PlaneUnknowns& x) {
  const double toward = std::cos((x[1] + x[2]) / 2);
  return x[0] * (x[3] + x[4]) / 2 * toward * toward;
}

double zero_disparity_m(const PlaneUnknowns& x) {
  const double parallax = parallax_of(x.data(), 0, 0);
  return parallax > 0 ? x[0] / parallax : std::numeric_limits<double>::infinity();
}

}  // namespace stof::host
