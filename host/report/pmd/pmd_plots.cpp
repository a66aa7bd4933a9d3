#include "host/report/pmd/pmd_plots.h"

#include <algorithm>
#include <cmath>

#include "host/picture/plot/plot.h"

namespace stof::host {
namespace {

constexpr double kMm = 1000;
constexpr double kCm = 100;
constexpr double kPercent = 100;
constexpr double kDotPx = 7;

PlotSeries series(const char* name, Rgb colour, bool line, double dot_px) {
  return {.name = name, .x = {}, .y = {}, .colour = colour, .line = line, .dot_px = dot_px};
}

void add(PlotSeries& to, double x, double y) {
  if (std::isfinite(y)) {
    to.x.push_back(x);
    to.y.push_back(y);
  }
}

// NaN interrupts a line.
void put(PlotSeries& to, double x, double y) {
  to.x.push_back(x);
  to.y.push_back(y);
}

// The middle one of the row's mixed pixels that have a reading; without any the row's middle.
int middle_edge(const EdgeSection& section) {
  std::vector<int> edges;
  for (std::size_t x = 0; x < section.mixed.size(); ++x) {
    if (section.mixed[x] != 0 && std::isfinite(section.reading[x])) {
      edges.push_back(static_cast<int>(x));
    }
  }
  return edges.empty() ? static_cast<int>(section.mixed.size()) / 2 : edges[edges.size() / 2];
}

Figure drawn(const Plot& plot, std::string caption) {
  return figure(plot_picture(plot), plot.title, std::move(caption));
}

// Eq. 15 in centimetres at 1, 2, 3 and 4 m.
constexpr std::array<double, 4> kChapterSigmaCm{0.52, 1.62, 3.28, 5.48};

PlotSeries polynomial(const WallStudy& study, double from_m, double to_m) {
  constexpr int kSteps = 100;
  PlotSeries curve = series("eq. 15, fitted", kPlotGreen, true, 0);
  for (int i = 0; i <= kSteps && study.calibration.sigma && from_m < to_m; ++i) {
    const double z = from_m + (to_m - from_m) * i / kSteps;
    add(curve, z, sigma_at(*study.calibration.sigma, z) * kCm);
  }
  return curve;
}

}  // namespace

std::vector<Figure> noise_figures(const WallStudy& study) {
  PlotSeries measured = series("measured", kPlotOrange, false, kDotPx + 2);
  PlotSeries model = series("the appliance says", kPlotBlue, true, kDotPx - 2);
  PlotSeries chapter = series("the chapter", kPlotGrey, false, kDotPx + 2);
  for (std::size_t i = 0; i < kChapterSigmaCm.size(); ++i) {
    add(chapter, static_cast<double>(i + 1), kChapterSigmaCm[i]);
  }
  for (const WallRow& row : study.report.rows) {
    if (row.exposure == 1) {
      add(measured, row.z_m, row.score.spread_m * kCm);
      add(model, row.z_m, row.score.predicted_m * kCm);
    }
  }
  if (measured.x.empty()) {
    return {};
  }
  const PlotSeries curve = polynomial(study, measured.x.front(), measured.x.back());
  return {drawn({.title = "Sigma of one reading over distance",
                 .x_label = "distance of the wall, m",
                 .y_label = "sigma, cm",
                 .series = {curve, chapter, model, measured},
                 .from_zero = true},
                "Standard deviation of a radial reading from frame to frame, pooled over the "
                "pixels in the middle of the picture, against what the appliance says about the "
                "same readings. Walls of the full integration time.")};
}

std::vector<Figure> calibration_figures(const WallStudy& study) {
  const std::optional<LineFit>& line = study.calibration.line;
  if (!line || line->a == 0) {
    return {};
  }
  PlotSeries walls = series("walls", kPlotOrange, false, kDotPx + 2);
  PlotSeries straight = series("z = a d + b", kPlotBlue, true, 0);
  PlotSeries residual = series("straight line alone", kPlotOrange, true, kDotPx);
  PlotSeries full = series("all constants", kPlotBlue, true, kDotPx);
  for (const WallRow& row : study.report.rows) {
    if (std::isfinite(row.line_error_m)) {
      const double reading = (row.z_m + row.line_error_m - line->b_m) / line->a;
      add(walls, reading, row.z_m);
      add(straight, reading, row.z_m + row.line_error_m);
    }
    add(residual, row.z_m, row.line_error_m / row.z_m * kPercent);
    add(full, row.z_m, row.score.error_m / row.z_m * kPercent);
  }
  constexpr double kMost = 5;
  return {drawn({.title = "The calibration line",
                 .x_label = "distance from the raw phase, m",
                 .y_label = "Z of the wall, m",
                 .series = {straight, walls}},
                "Mean over the middle of the picture. The line is fitted to walls from 1.5 m on; "
                "waves around it are those of the odd harmonics of the light."),
          drawn({.title = "What the line leaves, and what all constants leave",
                 .x_label = "distance of the wall, m",
                 .y_label = "error of Z, % of the distance",
                 .series = {residual, full},
                 .y_least = -kMost,
                 .y_most = kMost},
                "Mean error of Z over the middle of the picture, in frames that were not fitted "
                "to. All constants: offset, wiggling, fixed pattern, lights, stray light.")};
}

std::vector<Figure> ratio_figures(const WallStudy& study) {
  PlotSeries ratio = series("modulation ratio", kPlotBlue, true, kDotPx);
  PlotSeries limit = series("limit", kPlotGrey, true, 0);
  PlotSeries valid = series("valid share", kPlotGreen, true, kDotPx);
  PlotSeries amplitude = series("amplitude", kPlotOrange, true, kDotPx);
  const double least = study.calibration.sensor.frequency.min_modulation_ratio;
  for (std::size_t i = 0; i < study.views.size(); ++i) {
    const WallRow& row = study.report.rows[i];
    const WallView& view = study.views[i];
    if (view.valid_share.pixels.empty() || row.exposure != 1 || view.flagged[0] > 0) {
      continue;  // another integration time, or saturated
    }
    add(ratio, row.z_m, view.ratio);
    add(limit, row.z_m, least);
    add(valid, row.z_m, view.valid);
    add(amplitude, row.z_m, view.amp2 / 2);
  }
  if (ratio.x.empty()) {
    return {};
  }
  return {drawn({.title = "Amplitude over distance",
                 .x_label = "distance of the wall, m",
                 .y_label = "amplitude, LSB of a sample",
                 .series = {amplitude},
                 .from_zero = true},
                "Mean over the middle of the picture: light falls with the square of the "
                "distance."),
          drawn({.title = "Modulation ratio over distance",
                 .x_label = "distance of the wall, m",
                 .y_label = "amplitude / mean light (and share)",
                 .series = {limit, valid, ratio},
                 .from_zero = true},
                "Light that is not modulated and the sensor's own signal lower the ratio of far "
                "walls; readings below the limit are not given.")};
}

std::vector<Figure> stray_figures(const WallStudy& study) {
  if (study.stray.empty()) {
    return {};
  }
  PlotSeries truth = series("wall", kPlotGrey, true, 0);
  PlotSeries before = series("with stray light", kPlotOrange, true, kDotPx);
  PlotSeries after = series("stray light subtracted", kPlotBlue, true, kDotPx);
  PlotSeries ratio = series("with stray light", kPlotOrange, true, kDotPx);
  PlotSeries ratio_after = series("stray light subtracted", kPlotBlue, true, kDotPx);
  PlotSeries limit = series("limit", kPlotGrey, true, 0);
  for (const StrayRow& row : study.stray) {
    add(truth, row.z_m, row.z_m);
    add(before, row.z_m, row.z_m + row.before.error_m);
    add(after, row.z_m, row.z_m + row.after.error_m);
    add(ratio, row.z_m, row.before.ratio);
    add(ratio_after, row.z_m, row.after.ratio);
    add(limit, row.z_m, study.calibration.sensor.frequency.min_modulation_ratio);
  }
  return {drawn({.title = "A wall that seems to come nearer again",
                 .x_label = "distance of the wall, m",
                 .y_label = "mean Z of valid readings, m",
                 .series = {truth, before, after},
                 .from_zero = true},
                "Light that is always there adds one and the same phasor to every pixel. The "
                "wall's own light falls with distance until the phasor wins: beyond 3 to 4 m "
                "readings fall."),
          drawn({.title = "The ratio does not tell",
                 .x_label = "distance of the wall, m",
                 .y_label = "amplitude / mean light",
                 .series = {limit, ratio, ratio_after},
                 .from_zero = true},
                "Where wall and stray light are opposite the ratio falls below the limit; further "
                "away stray light alone looks like a good reading.")};
}

std::vector<Figure> light_figures(const LightStudy& study) {
  PlotSeries before = series("lights at the lens", kPlotOrange, true, kDotPx);
  PlotSeries after = series("near model", kPlotBlue, true, kDotPx);
  PlotSeries single = series("near model, single pixels", kPlotGrey, true, 0);
  for (const LightRow& row : study.rows) {
    add(before, row.z_m, row.before_blocks_m * kMm);
    add(after, row.z_m, row.after_blocks_m * kMm);
    add(single, row.z_m, row.after_m * kMm);
  }
  return {drawn({.title = "A light beside the lens",
                 .x_label = "distance of the wall, m",
                 .y_label = "mean size of the error, mm",
                 .series = {before, single, after},
                 .from_zero = true},
                "Radial error, mean over blocks of 8 by 8 pixels of the size of their mean error "
                "over the frames.")};
}

Figure section_figure(const EdgeStudy& study, int around_px) {
  const EdgeSection& s = study.section;
  const int width = static_cast<int>(s.reading.size());
  const int middle = middle_edge(s);
  PlotSeries nearest = series("surfaces", kPlotGrey, true, 0);
  PlotSeries farthest = series("", kPlotGrey, true, 0);
  PlotSeries low = series("interval", kPlotBlue, true, 0);
  PlotSeries high = series("", kPlotBlue, true, 0);
  PlotSeries least = series("minimum, maximum", kPlotGreen, true, 0);
  PlotSeries most = series("", kPlotGreen, true, 0);
  PlotSeries reading = series("reading", kPlotOrange, false, kDotPx + 1);
  for (int x = std::max(middle - around_px, 0); x < std::min(middle + around_px + 1, width); ++x) {
    const std::size_t i = static_cast<std::size_t>(x);
    put(nearest, x, s.nearest[i]);
    put(farthest, x, s.farthest[i]);
    put(low, x, s.low[i]);
    put(high, x, s.high[i]);
    put(least, x, s.least[i]);
    put(most, x, s.most[i]);
    put(reading, x, s.reading[i]);
  }
  return drawn({.title = "Across the edge: row " + std::to_string(s.row) + " of " + s.name,
                .x_label = "column, px",
                .y_label = "radial distance, m",
                .series = {nearest, farthest, low, high, least, most, reading}},
               "Surfaces: nearest and farthest inside each pixel. A pixel that sees two reads "
               "something between them. Minimum and maximum "
               "of 3 by 3 readings, widened by 2 sigma of each (the interval), hold both.");
}

}  // namespace stof::host
