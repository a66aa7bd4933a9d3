#include "host/report/pmd/pmd_plots.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "host/report/page/plot.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kDotPx = 4.5;

PlotSeries series(const char* name, Rgb colour, bool line, double dot_px) {
  return {.name = name, .colour = colour, .line = line, .dot_px = dot_px};
}

// Without what is not known; PlotSeries::add() lets it interrupt the line.
void add(PlotSeries& to, double x, double y) {
  if (std::isfinite(y)) {
    to.add(x, y);
  }
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

// Eq. 15 in centimetres at 1, 2, 3 and 4 m.
constexpr std::array<double, 4> kChapterSigmaCm{0.52, 1.62, 3.28, 5.48};

PlotSeries polynomial(const PmdCalibration& calibration, double from_m, double to_m) {
  constexpr int kSteps = 100;
  PlotSeries curve = series("eq. 15, fitted", kPlotGreen, true, 0);
  for (int i = 0; i <= kSteps && calibration.sigma && from_m < to_m; ++i) {
    const double z = from_m + (to_m - from_m) * i / kSteps;
    add(curve, z, sigma_at(*calibration.sigma, z) * kCm);
  }
  return curve;
}

// The mean over the pixels in the middle of one wall: what the phase has too much there, without
// the wiggling, against the phase.
struct Wiggle {
  double phi = 0;
  double excess = 0;
};
std::optional<Wiggle> wiggle_of(const PmdCalibration& calibration, const Wall& wall) {
  const WallData& data = calibration.data;
  const PmdModel& model = calibration.model;
  const Middle middle = middle_of(data.lens);
  std::complex<double> mean_phase;
  double sum = 0;
  double count = 0;
  for (int y = middle.top; y < middle.bottom; ++y) {
    for (int x = middle.left; x < middle.right; ++x) {
      const std::size_t p = static_cast<std::size_t>(y * data.lens.width + x);
      const Reading& r = wall.readings[p];
      if (r.saturated || !(data.rays[p][2] > 0)) {
        continue;
      }
      const double pattern = model.pattern.empty() ? 0 : model.pattern[p];
      const std::complex<double> signal =
          std::complex<double>(r.i, r.q) - wall.exposure * model.stray;
      const double turns = std::arg(signal) / (2 * std::numbers::pi);
      const double phi1 = (model.phase_falls ? -turns : turns) - model.offset - pattern;
      const double path = half_path(model.emitters, data.rays[p],
                                    distance_to_wall(model.wall_turn, data.rays[p], wall.z_m));
      const double phi2 = (path - model.shift_m) / (model.scale * model.turn_m);
      mean_phase += std::polar(1.0, 2 * std::numbers::pi * phi1);
      sum += wrapped(phi1 - phi2);
      count += 1;
    }
  }
  if (count == 0) {
    return std::nullopt;
  }
  const double phi = std::arg(mean_phase) / (2 * std::numbers::pi);
  return Wiggle{.phi = phi - std::floor(phi), .excess = sum / count};
}

}  // namespace

std::vector<Figure> noise_figures(const PmdReport& report, const PmdCalibration& calibration) {
  PlotSeries measured = series("measured", kPlotOrange, false, kDotPx + 1);
  PlotSeries model = series("the appliance says", kPlotBlue, true, kDotPx - 1);
  PlotSeries chapter = series("the chapter", kPlotGrey, false, kDotPx + 1);
  for (std::size_t i = 0; i < kChapterSigmaCm.size(); ++i) {
    add(chapter, static_cast<double>(i + 1), kChapterSigmaCm[i]);
  }
  for (const WallRow& row : report.rows) {
    if (row.exposure == 1) {
      add(measured, row.z_m, row.view.spread_m * kCm);
      add(model, row.z_m, row.view.predicted_m * kCm);
    }
  }
  if (measured.x.empty()) {
    return {};
  }
  const PlotSeries curve = polynomial(calibration, measured.x.front(), measured.x.back());
  return {
      plot_figure({.title = "Sigma of one reading over distance",
                   .x_label = "distance of the wall, m",
                   .y_label = "sigma, cm",
                   .series = {curve, chapter, model, measured},
                   .from_zero = true},
                  "Standard deviation of a radial reading from frame to frame, pooled over the "
                  "pixels in the middle of the picture, against what the appliance says about the "
                  "same readings. Walls of the full integration time.")};
}

std::vector<Figure> calibration_figures(const PmdReport& report,
                                        const PmdCalibration& calibration) {
  const std::optional<LineFit>& line = calibration.line;
  if (!line || line->a == 0) {
    return {};
  }
  PlotSeries walls = series("walls", kPlotOrange, false, kDotPx + 1);
  PlotSeries straight = series("z = a d + b", kPlotBlue, true, 0);
  PlotSeries residual = series("straight line alone", kPlotOrange, true, kDotPx);
  PlotSeries full = series("all constants", kPlotBlue, true, kDotPx);
  for (const WallRow& row : report.rows) {
    if (std::isfinite(row.line_error_m)) {
      const double reading = (row.z_m + row.line_error_m - line->b_m) / line->a;
      add(walls, reading, row.z_m);
      add(straight, reading, row.z_m + row.line_error_m);
    }
    add(residual, row.z_m, row.line_error_m / row.z_m * kPercent);
    add(full, row.z_m, row.view.error_m / row.z_m * kPercent);
  }
  constexpr double kMost = 5;
  return {
      plot_figure({.title = "The calibration line",
                   .x_label = "distance from the raw phase, m",
                   .y_label = "Z of the wall, m",
                   .series = {straight, walls}},
                  "Mean over the middle of the picture. The line is fitted to walls from 1.5 m on; "
                  "waves around it are those of the odd harmonics of the light."),
      plot_figure({.title = "What the line leaves, and what all constants leave",
                   .x_label = "distance of the wall, m",
                   .y_label = "error of Z, % of the distance",
                   .series = {residual, full},
                   .y_least = -kMost,
                   .y_most = kMost},
                  std::string("Mean error of Z over the middle of the picture, ") +
                      (report.judged == Frames::kAll ? "in all frames"
                                                     : "in frames that were not fitted to") +
                      ". All constants: offset, wiggling, fixed pattern, lights, stray light.")};
}

std::vector<Figure> wiggling_figures(const PmdCalibration& calibration) {
  constexpr int kSteps = 512;
  const PmdModel& model = calibration.model;
  PlotSeries curve = series("table W", kPlotBlue, true, 0);
  for (int i = 0; i <= kSteps; ++i) {
    const double phi = static_cast<double>(i) / kSteps;
    curve.add(phi, model.wiggling.at(phi) * model.turn_m * kMm);
  }
  PlotSeries seen = series("walls, middle of the picture", kPlotOrange, false, kDotPx);
  for (const Wall& wall : calibration.data.walls) {
    if (const std::optional<Wiggle> wiggle = wiggle_of(calibration, wall)) {
      seen.add(wiggle->phi, wiggle->excess * model.turn_m * kMm);
    }
  }
  return {plot_figure({.title = "Wiggling: what the phase has too much",
                       .x_label = "phase, turns",
                       .y_label = "W, mm",
                       .series = {curve, seen}},
                      "The table that the appliance subtracts, and each wall without it.")};
}

std::vector<Figure> ratio_figures(const WallStudy& study) {
  PlotSeries ratio = series("modulation ratio", kPlotBlue, true, kDotPx);
  PlotSeries limit = series("limit", kPlotGrey, true, 0);
  PlotSeries valid = series("valid share", kPlotGreen, true, kDotPx);
  PlotSeries amplitude = series("amplitude", kPlotOrange, true, kDotPx);
  const double least = study.calibration.sensor.frequency.min_modulation_ratio;
  for (const WallRow& row : study.report.rows) {
    const WallView& view = row.view;
    if (row.exposure != 1 || view.flagged[0] > 0) {
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
  return {
      plot_figure({.title = "Amplitude over distance",
                   .x_label = "distance of the wall, m",
                   .y_label = "amplitude, LSB of a sample",
                   .series = {amplitude},
                   .from_zero = true},
                  "Mean over the middle of the picture: light falls with the square of the "
                  "distance."),
      plot_figure({.title = "Modulation ratio over distance",
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
  return {plot_figure({.title = "A wall that seems to come nearer again",
                       .x_label = "distance of the wall, m",
                       .y_label = "mean Z of valid readings, m",
                       .series = {truth, before, after},
                       .from_zero = true},
                      "Light that is always there adds one and the same phasor to every pixel. The "
                      "wall's own light falls with distance until the phasor wins: beyond 3 to 4 m "
                      "readings fall."),
          plot_figure(
              {.title = "The ratio does not tell",
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
  return {
      plot_figure({.title = "A light beside the lens",
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
    nearest.add(x, s.nearest[i]);
    farthest.add(x, s.farthest[i]);
    low.add(x, s.low[i]);
    high.add(x, s.high[i]);
    least.add(x, s.least[i]);
    most.add(x, s.most[i]);
    reading.add(x, s.reading[i]);
  }
  return plot_figure(
      {.title = "Across the edge: row " + std::to_string(s.row) + " of " + s.name,
       .x_label = "column, px",
       .y_label = "radial distance, m",
       .series = {nearest, farthest, low, high, least, most, reading}},
      "Surfaces: nearest and farthest inside each pixel. A pixel that sees two reads "
      "something between them. Minimum and maximum "
      "of 3 by 3 readings, widened by 2 sigma of each (the interval), hold both.");
}

}  // namespace stof::host
