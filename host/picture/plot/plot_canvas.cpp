#include "host/picture/plot/plot_canvas.h"

#include <algorithm>
#include <cmath>

#include "host/text/printed.h"

namespace stof::host {
namespace {

std::uint8_t mixed(std::uint8_t below, std::uint8_t above, double share) {
  return static_cast<std::uint8_t>(std::lround(below + (above - below) * share));
}

}  // namespace

Rgb blended(Rgb below, Rgb above, double share) {
  const double part = std::clamp(share, 0.0, 1.0);
  return {mixed(below.red, above.red, part), mixed(below.green, above.green, part),
          mixed(below.blue, above.blue, part)};
}

void Canvas::blend(int x, int y, Rgb colour, double share) {
  if (x < 0 || x >= picture_.width || y < 0 || y >= picture_.height || share <= 0) {
    return;
  }
  Rgb& pixel = picture_.view().row(y)[static_cast<std::size_t>(x)];
  pixel = blended(pixel, colour, share);
}

void Canvas::box(int left, int top, int right, int bottom, Rgb colour) {
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      blend(x, y, colour, 1);
    }
  }
}

void Canvas::stroke(const Area& area, std::array<double, 2> a, std::array<double, 2> b,
                    double width, Rgb colour) {
  const double reach = width / 2 + 1;
  const int x_end = std::min(static_cast<int>(std::ceil(std::max(a[0], b[0]) + reach)), area.right);
  const int y_end =
      std::min(static_cast<int>(std::ceil(std::max(a[1], b[1]) + reach)), area.bottom);
  const int x_begin =
      std::max(static_cast<int>(std::floor(std::min(a[0], b[0]) - reach)), area.left);
  const int y_begin =
      std::max(static_cast<int>(std::floor(std::min(a[1], b[1]) - reach)), area.top);
  const double dx = b[0] - a[0];
  const double dy = b[1] - a[1];
  const double square = dx * dx + dy * dy;
  for (int y = y_begin; y <= y_end; ++y) {
    for (int x = x_begin; x <= x_end; ++x) {
      const double along =
          square > 0 ? std::clamp(((x - a[0]) * dx + (y - a[1]) * dy) / square, 0.0, 1.0) : 0;
      const double away = std::hypot(x - a[0] - along * dx, y - a[1] - along * dy);
      blend(x, y, colour, width / 2 + 0.5 - away);
    }
  }
}

std::string number_text(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return printed("%.*f", decimals, std::abs(value) < step / 2 ? 0 : value);
}

}  // namespace stof::host
