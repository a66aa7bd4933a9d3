#include "host/picture/plot/plot.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/picture/plot/plot_canvas.h"
#include "host/picture/plot/plot_text.h"

namespace stof::host {
namespace {

constexpr Rgb kGrid{226, 226, 226};
constexpr int kLeastWidth = 200;
constexpr int kLeastHeight = 150;
constexpr double kLineWidthPx = 2.2;

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void hold(double value) noexcept {
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  double size() const noexcept { return high - low; }
};

// Room around the data, and something to divide by.
Span widened(Span span, double share) {
  if (!(span.low <= span.high)) {
    return {.low = 0, .high = 1};
  }
  const double room =
      span.size() > 0 ? span.size() * share : std::max(std::abs(span.low) * share, 1e-9);
  return {.low = span.low - room, .high = span.high + room};
}

// Where numbers lie on the picture.
struct Frame {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
  Span x;
  Span y;

  double u(double value) const noexcept {
    return left + (value - x.low) / x.size() * (right - left);
  }
  double v(double value) const noexcept {
    return bottom - (value - y.low) / y.size() * (bottom - top);
  }
};

bool shown(const Plot& plot, double y) { return y >= plot.y_least && y <= plot.y_most; }

Frame frame_of(const Plot& plot) {
  Frame frame;
  for (const PlotSeries& series : plot.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (std::isfinite(series.x[i]) && std::isfinite(series.y[i])) {
        frame.x.hold(series.x[i]);
        frame.y.hold(std::clamp(series.y[i], plot.y_least, plot.y_most));
      }
    }
  }
  frame.x = widened(frame.x, 0.02);
  frame.y = widened(frame.y, 0.06);
  if (plot.from_zero) {
    frame.y.low = 0;
    frame.y.high = frame.y.high > 0 ? frame.y.high : 1;
  }
  return frame;
}

void draw_axes(Canvas& canvas, const Plot& plot, Frame& frame) {
  const std::vector<double> y_ticks = round_ticks(frame.y.low, frame.y.high, 7);
  const std::vector<double> x_ticks = round_ticks(frame.x.low, frame.x.high, 9);
  const auto step_of = [](const std::vector<double>& ticks) {
    return ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  };
  int widest = 0;
  for (const double tick : y_ticks) {
    widest = std::max(widest, label_width(number_text(tick, step_of(y_ticks))));
  }
  const bool legend =
      std::ranges::any_of(plot.series, [](const auto& s) { return !s.name.empty(); });
  frame.left = kPlotMargin + kLabelHeight + 2 * kPlotGap + widest + kPlotGap;
  frame.right = plot.width - 2 * kPlotMargin;
  frame.top =
      kPlotMargin + kLabelHeight + 2 * kPlotGap + (legend ? kLabelHeight + 2 * kPlotGap : 0);
  frame.bottom = plot.height - kPlotMargin - 2 * (kLabelHeight + kPlotGap) - kPlotGap;
  dataset::Image<Rgb>& picture = canvas.picture();
  for (const double tick : x_ticks) {
    const int u = static_cast<int>(std::lround(frame.u(tick)));
    canvas.box(u, frame.top, u + 1, frame.bottom, kGrid);
    const std::string text = number_text(tick, step_of(x_ticks));
    draw_label(picture, u - label_width(text) / 2, frame.bottom + kPlotGap, text, kPlotInk);
  }
  for (const double tick : y_ticks) {
    const int v = static_cast<int>(std::lround(frame.v(tick)));
    canvas.box(frame.left, v, frame.right, v + 1, tick == 0 ? kPlotGrey : kGrid);
    const std::string text = number_text(tick, step_of(y_ticks));
    draw_label(picture, frame.left - kPlotGap - label_width(text), v - kLabelHeight / 2, text,
               kPlotInk);
  }
  canvas.box(frame.left, frame.top, frame.left + 1, frame.bottom, kPlotInk);
  canvas.box(frame.left, frame.bottom, frame.right, frame.bottom + 1, kPlotInk);
  draw_label(picture, frame.left, kPlotMargin, plot.title, kPlotInk);
  const int x_middle = (frame.left + frame.right - label_width(plot.x_label)) / 2;
  draw_label(picture, x_middle, plot.height - kPlotMargin - kLabelHeight, plot.x_label, kPlotInk);
  const int y_middle = (frame.top + frame.bottom + label_width(plot.y_label)) / 2;
  draw_label_upwards(picture, kPlotMargin, y_middle, plot.y_label, kPlotInk);
}

void draw_series(Canvas& canvas, const Plot& plot, const Frame& frame, const PlotSeries& series) {
  const Area area{
      .left = frame.left, .top = frame.top, .right = frame.right, .bottom = frame.bottom};
  const std::size_t count = std::min(series.x.size(), series.y.size());
  const auto place = [&](std::size_t i) {
    return std::array{frame.u(series.x[i]), frame.v(series.y[i])};
  };
  const auto finite = [&](std::size_t i) {
    return std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (series.line && i > 0 && finite(i) && finite(i - 1)) {
      canvas.stroke(area, place(i - 1), place(i), kLineWidthPx, series.colour);
    }
    if (series.dot_px > 0 && finite(i) && shown(plot, series.y[i])) {
      canvas.stroke(area, place(i), place(i), series.dot_px, series.colour);
    }
  }
}

void draw_legend(Canvas& canvas, const Plot& plot, const Frame& frame) {
  constexpr int kSample = 26;
  int x = frame.left;
  const int y = frame.top - kLabelHeight - kPlotGap;
  const Area all{.left = 0, .top = 0, .right = plot.width, .bottom = plot.height};
  for (const PlotSeries& series : plot.series) {
    if (series.name.empty()) {
      continue;
    }
    const double v = y + kLabelHeight / 2.0;
    const std::array<double, 2> begin{static_cast<double>(x), v};
    const std::array<double, 2> end{static_cast<double>(x + kSample), v};
    const std::array<double, 2> middle{x + kSample / 2.0, v};
    if (series.line) {
      canvas.stroke(all, begin, end, kLineWidthPx, series.colour);
    }
    if (series.dot_px > 0) {
      canvas.stroke(all, middle, middle, std::max(series.dot_px, 4.0), series.colour);
    }
    draw_label(canvas.picture(), x + kSample + kPlotGap, y, series.name, kPlotInk);
    x += kSample + kPlotGap + label_width(series.name) + 3 * kPlotGap;
  }
}

}  // namespace

std::vector<double> round_ticks(double low, double high, int count) {
  const double raw = (high - low) / std::max(count, 1);
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    step = factor * power >= raw * (1 - 1e-9) ? factor * power : step;
  }
  std::vector<double> ticks;
  for (double n = std::ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n += 1) {
    ticks.push_back(n == 0 ? 0 : n * step);
  }
  return ticks;
}

dataset::Image<Rgb> plot_picture(const Plot& plot) {
  if (plot.width < kLeastWidth || plot.height < kLeastHeight) {
    Plot larger = plot;
    larger.width = std::max(plot.width, kLeastWidth);
    larger.height = std::max(plot.height, kLeastHeight);
    return plot_picture(larger);
  }
  Canvas canvas(plot.width, plot.height);
  Frame frame = frame_of(plot);
  draw_axes(canvas, plot, frame);
  for (const PlotSeries& series : plot.series) {
    draw_series(canvas, plot, frame, series);
  }
  draw_legend(canvas, plot, frame);
  return std::move(canvas.picture());
}

}  // namespace stof::host
