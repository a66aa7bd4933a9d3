#pragma once

#include "host/picture/png.h"

namespace stof::host {

// Maps of errors: values that may be too low or too high.

// The colour of an error: -1 and below blue, 0 white, 1 and above red; grey for what is not finite.
Rgb error_colour(double value);

// The largest absolute value of what is finite; 1 where there is none or all are 0.
double largest_error(const dataset::Image<float>& values);

// Each error in the colour of error / most.
dataset::Image<Rgb> error_picture(const dataset::Image<float>& values, double most);

// The same of relative errors of depth, with a legend beside it: so many percent too near, 0, so
// many too far, none.
dataset::Image<Rgb> depth_error_picture(const dataset::Image<float>& values, double most);

}  // namespace stof::host
