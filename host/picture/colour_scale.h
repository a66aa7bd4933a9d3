#pragma once

#include <vector>

#include "host/picture/png.h"

namespace stof::host {

// Near is warm, far is cold, on a logarithmic scale that does not depend on the picture: the same
// distance has the same colour in every frame. 0 < near_m < far_m; what lies outside has the colour
// of the end.
struct ColourScale {
  double near_m = 1;
  double far_m = 8;

  // 0 at near_m and before, 1 at far_m and beyond. depth_m > 0.
  double position(double depth_m) const;
  Rgb colour(double depth_m) const;
  // Round distances inside the scale, near first: 1, 1.5, 2, 3, 5, 7 times a power of ten; where
  // those are fewer than three, some that are equally far apart.
  std::vector<double> ticks() const;
};

// The colour of a place of the scale, 0 (near, red) to 1 (far, violet). Lightness falls towards
// both ends from yellow, in OKLCH, so that neighbouring distances differ about equally to the eye.
Rgb scale_colour(double position);

// From a (share 0) to b (share 1), channel by channel.
Rgb mixed(Rgb a, Rgb b, double share_of_b);

// About `count` round numbers (1, 2 or 5 times a power of ten apart) that span low .. high from
// within; low < high.
std::vector<double> round_ticks(double low, double high, int count);

}  // namespace stof::host
