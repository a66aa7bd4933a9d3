#pragma once

#include "host/picture/png.h"

namespace stof::host {

// Maps of values that may be too low or too high.

// The colour of a value: -1 and below blue, 0 white, 1 and above red; grey for what is not finite.
Rgb signed_colour(double value);

// The largest size of a finite value; 1 where there is none or all are 0.
double largest_size(const dataset::Image<float>& values);

// Each value in the colour of value / most.
dataset::Image<Rgb> signed_picture(const dataset::Image<float>& values, double most);

}  // namespace stof::host
