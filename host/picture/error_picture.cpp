#include "host/picture/error_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/picture/colour_scale.h"
#include "host/picture/legend.h"
#include "host/text/printed.h"

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

dataset::Image<Rgb> depth_error_picture(const dataset::Image<float>& values, double most) {
  return with_legend(
      error_picture(values, most),
      {.colour = [](double place) { return error_colour(2 * place - 1); },
       .ticks = {{0, printed("%g%% near", kPercent * most)},
                 {0.5, "0"},
                 {1, printed("%g%% far", kPercent * most)}},
       .none = [](int /*x*/,
                  int /*y*/) { return error_colour(std::numeric_limits<double>::quiet_NaN()); }});
}

}  // namespace stof::host
