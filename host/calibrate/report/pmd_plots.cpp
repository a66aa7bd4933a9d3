#include "host/calibrate/report/pmd_plots.h"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "host/picture/plot/plot.h"
#include "host/picture/plot/plot_map.h"

namespace stof::host {
namespace {

using Written = std::expected<void, dataset::Problem>;

constexpr double kMm = 1000;
constexpr double kCm = 100;
constexpr double kPercent = 100;
constexpr double kDotPx = 7;
constexpr double kMostPercent = 5;  // nearer than 1 m a line alone is off by more

PlotSeries series(const char* name, Rgb colour, bool line, double dot_px) {
  return {.name = name, .x = {}, .y = {}, .colour = colour, .line = line, .dot_px = dot_px};
}

void add(PlotSeries& to, double x, double y) {
  to.x.push_back(x);
  to.y.push_back(y);
}

Plot residual_plot(const PmdReport& report) {
  PlotSeries line = series("straight line alone", kPlotOrange, true, kDotPx);
  PlotSeries full = series("calibrated", kPlotBlue, true, kDotPx);
  for (const WallRow& row : report.rows) {
    if (std::isfinite(row.line_error_m)) {
      add(line, row.z_m, row.line_error_m / row.z_m * kPercent);
    }
    if (std::isfinite(row.score.error_m)) {
      add(full, row.z_m, row.score.error_m / row.z_m * kPercent);
    }
  }
  return {.title = "Error of Z, mean over the middle of the picture",
          .x_label = "distance of the wall, m",
          .y_label = "error, % of the distance",
          .series = {line, full},
          .y_least = -kMostPercent,
          .y_most = kMostPercent};
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
      const double path = half_path(model.emitters, data.rays[p], wall.z_m / data.rays[p][2]);
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

Plot wiggling_plot(const PmdCalibration& calibration) {
  constexpr int kSteps = 512;
  const PmdModel& model = calibration.model;
  PlotSeries curve = series("table W", kPlotBlue, true, 0);
  for (int i = 0; i <= kSteps; ++i) {
    const double phi = static_cast<double>(i) / kSteps;
    add(curve, phi, model.wiggling.at(phi) * model.turn_m * kMm);
  }
  PlotSeries seen = series("walls, middle of the picture", kPlotOrange, false, kDotPx);
  for (const Wall& wall : calibration.data.walls) {
    if (const std::optional<Wiggle> wiggle = wiggle_of(calibration, wall)) {
      add(seen, wiggle->phi, wiggle->excess * model.turn_m * kMm);
    }
  }
  return {.title = "Wiggling: what the phase has too much",
          .x_label = "phase, turns",
          .y_label = "W, mm",
          .series = {curve, seen}};
}

// Walls of the reference integration time alone: the others lie on a curve of their own.
Plot sigma_plot(const PmdReport& report, const PmdCalibration& calibration) {
  PlotSeries measured = series("spread over frames", kPlotOrange, false, kDotPx + 2);
  PlotSeries model = series("noise model", kPlotBlue, true, kDotPx - 2);
  PlotSeries chapter = series("eq. 15, fitted", kPlotGreen, true, 0);
  double low = std::numeric_limits<double>::infinity();
  double high = 0;
  for (const WallRow& row : report.rows) {
    if (row.exposure == 1 && std::isfinite(row.score.spread_m)) {
      add(measured, row.z_m, row.score.spread_m * kCm);
      add(model, row.z_m, row.score.predicted_m * kCm);
      low = std::min(low, row.z_m);
      high = std::max(high, row.z_m);
    }
  }
  constexpr int kSteps = 200;
  for (int i = 0; i <= kSteps && calibration.sigma && low < high; ++i) {
    const double z = low + (high - low) * i / kSteps;
    add(chapter, z, sigma_at(*calibration.sigma, z) * kCm);
  }
  return {.title = "Sigma of one reading, middle of the picture",
          .x_label = "distance of the wall, m",
          .y_label = "sigma, cm",
          .series = {chapter, model, measured},
          .from_zero = true};
}

Written write_map(const std::filesystem::path& file, const PmdCalibration& calibration) {
  const dsp::Pinhole& lens = calibration.data.lens;
  const std::vector<double>& pattern = calibration.model.pattern;
  dataset::Image<float> map(lens.width, lens.height);
  for (std::size_t p = 0; p < pattern.size(); ++p) {
    map.pixels[p] = static_cast<float>(pattern[p] * calibration.model.turn_m * kMm);
  }
  return write_png(file, map_picture(map, "Fixed pattern of the distance", "mm"), {});
}

}  // namespace

Written write_plots(const std::filesystem::path& folder, const PmdReport& report,
                    const PmdCalibration& calibration) {
  Written done = write_png(folder / "residual.png", plot_picture(residual_plot(report)), {});
  if (done) {
    done = write_png(folder / "wiggling.png", plot_picture(wiggling_plot(calibration)), {});
  }
  if (done) {
    done = write_png(folder / "sigma.png", plot_picture(sigma_plot(report, calibration)), {});
  }
  if (done && !calibration.model.pattern.empty()) {
    done = write_map(folder / "pattern.png", calibration);
  }
  return done;
}

}  // namespace stof::host
