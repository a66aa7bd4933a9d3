#include "host/picture/plot/plot_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/picture/plot/plot_canvas.h"
#include "host/picture/plot/plot_text.h"

namespace stof::host {
namespace {

constexpr Rgb kUnknown{200, 200, 200};

// -1 is blue, 0 white, 1 red.
Rgb diverging(double value) {
  constexpr Rgb kBelow{33, 102, 172};
  constexpr Rgb kAbove{178, 24, 43};
  const double share = std::min(std::abs(value), 1.0);
  const Rgb end = value < 0 ? kBelow : kAbove;
  return blended({255, 255, 255}, end, share);
}

double largest_size(const dataset::Image<float>& values) {
  double most = 0;
  for (const float value : values.pixels) {
    most = std::isfinite(value) ? std::max(most, std::abs(static_cast<double>(value))) : most;
  }
  return most > 0 ? most : 1;
}

}  // namespace

dataset::Image<Rgb> map_picture(const dataset::Image<float>& values, const std::string& title,
                                const std::string& unit) {
  constexpr int kWidest = 832;
  constexpr int kBar = 18;
  const double most = largest_size(values);
  const int square = std::max(kWidest / std::max(values.width, 1), 1);
  const int wide = square * values.width;
  const int tall = std::max(square * values.height, 5 * kLabelHeight);
  const int top = kPlotMargin + kLabelHeight + kPlotGap;
  const std::array<std::string, 3> labels{number_text(most, most / 50) + " " + unit, "0",
                                          number_text(-most, most / 50) + " " + unit};
  const int label = std::max(label_width(labels[0]), label_width(labels[2]));
  const int bar = kPlotMargin + wide + 2 * kPlotGap;
  Canvas canvas(
      std::max(bar + kBar + kPlotGap + label, kPlotMargin + label_width(title)) + kPlotMargin,
      top + tall + kPlotMargin);
  draw_label(canvas.picture(), kPlotMargin, kPlotMargin, title, kPlotInk);
  for (int y = 0; y < values.height; ++y) {
    for (int x = 0; x < values.width; ++x) {
      const double value = values.view().row(y)[static_cast<std::size_t>(x)];
      const int left = kPlotMargin + x * square;
      const int above = top + y * square;
      canvas.box(left, above, left + square, above + square,
                 std::isfinite(value) ? diverging(value / most) : kUnknown);
    }
  }
  for (int y = 0; y < tall; ++y) {
    canvas.box(bar, top + y, bar + kBar, top + y + 1, diverging(1 - 2.0 * y / (tall - 1)));
  }
  for (int i = 0; i < 3; ++i) {
    draw_label(canvas.picture(), bar + kBar + kPlotGap, top + i * (tall - kLabelHeight) / 2,
               labels[static_cast<std::size_t>(i)], kPlotInk);
  }
  return std::move(canvas.picture());
}

}  // namespace stof::host
