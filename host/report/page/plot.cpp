#include "host/report/page/plot.h"

#include <algorithm>
#include <cmath>

#include "host/report/page/legend.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// The drawing has units of its own; the page scales it to the width of the figure.
constexpr double kWidth = 480;
constexpr double kHeight = 300;
constexpr double kTop = 10;
constexpr double kBottom = kHeight - 42;
constexpr double kRight = kWidth - 14;
constexpr double kLetter = 7;  // as wide as a digit of the style sheet's .plot text

// The numbers that one axis shows, and where they lie on the drawing.
struct Axis {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  double from = 0;  // of the drawing
  double to = 1;

  void hold(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  // Adds room around the data, so that there is something to divide by.
  void widen(double share) {
    if (!(low <= high)) {
      low = 0;
      high = 1;
      return;
    }
    const double room = high > low ? (high - low) * share : std::max(std::abs(low) * share, 1e-9);
    low -= room;
    high += room;
  }
  double place(double value) const { return from + (value - low) / (high - low) * (to - from); }
};

struct Axes {
  Axis x;
  Axis y;
};

bool finite(const PlotSeries& series, std::size_t i) {
  return std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
}

Axes axes_of(const Plot& plot) {
  Axes axes;
  for (const PlotSeries& series : plot.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (finite(series, i)) {
        axes.x.hold(series.x[i]);
        axes.y.hold(std::clamp(series.y[i], plot.y_least, plot.y_most));
      }
    }
  }
  axes.x.widen(0.02);
  axes.y.widen(0.06);
  if (plot.from_zero) {
    axes.y.low = 0;
    axes.y.high = axes.y.high > 0 ? axes.y.high : 1;
  }
  return axes;
}

struct AxisTick {
  double value;
  std::string text;
};

std::vector<AxisTick> ticks_of(const Axis& axis, int count) {
  const std::vector<double> values = round_ticks(axis.low, axis.high, count);
  const double step = values.size() > 1 ? values[1] - values[0] : 1;
  std::vector<AxisTick> ticks;
  ticks.reserve(values.size());
  for (const double value : values) {
    ticks.push_back({value, tick_text(value, step)});
  }
  return ticks;
}

std::string text_at(double x, double y, const char* anchor, const std::string& text) {
  return printed(R"(<text x="%.1f" y="%.1f" text-anchor="%s">%s</text>)", x, y, anchor,
                 escaped(text).c_str());
}

// Grid, numbers and labels. Sets where the axes lie on the drawing.
std::string draw_axes(const Plot& plot, Axes& axes) {
  const std::vector<AxisTick> x_ticks = ticks_of(axes.x, 9);
  const std::vector<AxisTick> y_ticks = ticks_of(axes.y, 7);
  std::size_t letters = 0;
  for (const AxisTick& tick : y_ticks) {
    letters = std::max(letters, tick.text.size());
  }
  const double left = 30 + kLetter * static_cast<double>(letters);
  axes.x.from = left;
  axes.x.to = kRight;
  axes.y.from = kBottom;
  axes.y.to = kTop;
  std::string grid;
  std::string zero;
  std::string text;
  for (const AxisTick& tick : x_ticks) {
    const double x = axes.x.place(tick.value);
    grid += printed("M%.1f %gV%g", x, kTop, kBottom);
    text += text_at(x, kBottom + 16, "middle", tick.text);
  }
  for (const AxisTick& tick : y_ticks) {
    const double y = axes.y.place(tick.value);
    (tick.value == 0 ? zero : grid) += printed("M%g %.1fH%g", left, y, kRight);
    text += text_at(left - 6, y + 4, "end", tick.text);
  }
  text += text_at((left + kRight) / 2, kHeight - 6, "middle", plot.x_label);
  text += printed(R"svg(<g transform="translate(13 %g) rotate(-90)">)svg", (kTop + kBottom) / 2) +
          text_at(0, 0, "middle", plot.y_label) + "</g>";
  const std::string frame = printed("M%g %gV%gH%g", left, kTop, kBottom, kRight);
  return R"(<path class="grid" d=")" + grid + R"("/><path class="zero" d=")" + zero +
         R"("/><path class="axes" d=")" + frame + R"("/>)" + text;
}

std::string stroke(const std::string& path, const PlotSeries& series, double width) {
  return R"(<path d=")" + path + R"(" stroke=")" + css_colour(series.colour) +
         printed(R"(" stroke-width="%g"/>)", width);
}

std::string draw_series(const Plot& plot, const Axes& axes, const PlotSeries& series) {
  constexpr double kLineWidth = 1.6;
  std::string line;
  std::string dots;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!finite(series, i)) {
      continue;
    }
    const double x = axes.x.place(series.x[i]);
    const double y = axes.y.place(series.y[i]);
    line += printed("%c%.1f %.1f", i > 0 && finite(series, i - 1) ? 'L' : 'M', x, y);
    if (series.y[i] >= plot.y_least && series.y[i] <= plot.y_most) {
      dots += printed("M%.1f %.1fh0", x, y);  // a line without length has round ends alone
    }
  }
  return (series.line ? stroke(line, series, kLineWidth) : "") +
         (series.dot_px > 0 ? stroke(dots, series, series.dot_px) : "");
}

}  // namespace

Figure plot_figure(const Plot& plot, std::string caption) {
  Axes axes = axes_of(plot);
  std::string svg =
      printed(R"(<svg class="plot" viewBox="0 0 %g %g" role="img" aria-label=")", kWidth, kHeight) +
      escaped(plot.title) + R"(">)" + draw_axes(plot, axes);
  // An inner drawing of the same units cuts what lies beyond the axes.
  const double width = axes.x.to - axes.x.from;
  svg += printed(R"(<svg x="%g" y="%g" width="%g" height="%g" viewBox="%g %g %g %g">)", axes.x.from,
                 kTop, width, kBottom - kTop, axes.x.from, kTop, width, kBottom - kTop);
  std::vector<std::pair<Rgb, std::string>> names;
  for (const PlotSeries& series : plot.series) {
    svg += draw_series(plot, axes, series);
    if (!series.name.empty()) {
      names.emplace_back(series.colour, series.name);
    }
  }
  return {.picture = svg + "</svg></svg>",
          .title = plot.title,
          .caption = std::move(caption),
          .legend = colour_legend(names)};
}

}  // namespace stof::host
