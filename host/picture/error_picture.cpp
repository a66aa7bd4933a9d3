#include "host/picture/error_picture.h"

#include <algorithm>
#include <cmath>

#include "host/picture/colour_scale.h"

namespace stof::host {

Rgb error_colour(double value) {
  constexpr Rgb kUnknown{200, 200, 200};
  constexpr Rgb kWhite{255, 255, 255};
  constexpr Rgb kBelow{33, 102, 172};
  constexpr Rgb kAbove{178, 24, 43};
  if (!std::isfinite(value)) {
    return kUnknown;
  }
  return mixed(kWhite, value < 0 ? kBelow : kAbove, std::min(std::abs(value), 1.0));
}

double largest_error(const dataset::Image<float>& values) {
  double most = 0;
  for (const float value : values.pixels) {
    most = std::isfinite(value) ? std::max(most, std::abs(static_cast<double>(value))) : most;
  }
  return most > 0 ? most : 1;
}

dataset::Image<Rgb> error_picture(const dataset::Image<float>& values, double most) {
  dataset::Image<Rgb> picture(values.width, values.height);
  std::ranges::transform(values.pixels, picture.pixels.begin(),
                         [most](float value) { return error_colour(value / most); });
  return picture;
}

}  // namespace stof::host
