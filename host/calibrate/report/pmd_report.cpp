#include "host/calibrate/report/pmd_report.h"

#include <algorithm>
#include <cmath>

#include "host/text/printed.h"

namespace stof::host {
namespace {

std::string in_words(Frames frames) {
  return (frames == Frames::kAll ? "" : "the ") + std::string(to_string(frames)) + " frames";
}

void add_table(const PmdReport& report, const PmdCalibration& calibration, std::string& text) {
  text +=
      printed("%7s  %17s  %17s  %6s  %24s\n", "", "straight line", "calibrated", "", "sigma, cm");
  text += printed("%7s  %8s %8s  %8s %8s  %6s  %8s %7s %7s  %s\n", "z, m", "mm", "%", "mm", "%",
                  "valid", "measured", "model", "eq. 15", "recording");
  for (const WallRow& row : report.rows) {
    const WallView& view = row.view;
    const double polynomial =
        calibration.sigma ? sigma_at(*calibration.sigma, row.z_m) * kCm : std::nan("");
    text +=
        printed("%7.3f  %s %s  %s %s  %s  %s %s %s  %s", row.z_m,
                cell(row.line_error_m * kMm, 8, 1).c_str(),
                cell(row.line_error_m / row.z_m * kPercent, 8, 3).c_str(),
                cell(view.error_m * kMm, 8, 1).c_str(),
                cell(view.error_m / row.z_m * kPercent, 8, 3).c_str(),
                cell(view.valid * kPercent, 5, 0).c_str(), cell(view.spread_m * kCm, 9, 2).c_str(),
                cell(view.predicted_m * kCm, 7, 2).c_str(), cell(polynomial, 7, 2).c_str(),
                row.name.c_str());
    if (row.exposure != 1) {
      text += printed(" (%.3g of the integration time)", row.exposure);
    }
    text += '\n';
  }
}

void add_line(const PmdCalibration& calibration, std::string& text) {
  if (!calibration.line) {
    return;
  }
  const LineFit& line = *calibration.line;
  text += printed("straight line   z = %.5f d %+.4f m; at worst %.2f %% of walls from %.2f m on\n",
                  line.a, line.b_m, line.worst_relative * kPercent, line.from_m);
  text += printed(
      "                as the chapter counts phi, down with distance and 138.7 a turn: z[cm] = "
      "%.4f phi + %.1f (the chapter: -5.4022 phi + 672.5)\n",
      line.slope_cm, line.intercept_cm);
}

void add_wiggling(const PmdCalibration& calibration, std::string& text) {
  const PmdModel& model = calibration.model;
  double most = 0;
  for (int i = 0; i < dsp::kWigglingSteps; ++i) {
    most =
        std::max(most, std::abs(model.wiggling.at(static_cast<double>(i) / dsp::kWigglingSteps)));
  }
  text += printed("wiggling        up to %.1f mm", most * model.turn_m * kMm);
  if (!calibration.parts.wiggling) {
    text += ", kept\n";
    return;
  }
  text += "; harmonics, mm:";
  for (std::size_t h = 0; h < model.wiggling.sine.size(); ++h) {
    const double size = std::hypot(model.wiggling.cosine[h], model.wiggling.sine[h]);
    text += printed(" %.1f", size * model.turn_m * kMm);
  }
  text += printed("\n                phases are known but for %.0f %% of a turn in one piece%s\n",
                  calibration.widest_gap * kPercent,
                  calibration.widest_gap > 0.2
                      ? ": record walls between, or do not rely on what lies there"
                      : "");
}

void add_pattern(const PmdCalibration& calibration, std::string& text) {
  const std::vector<double>& pattern = calibration.model.pattern;
  if (pattern.empty()) {
    text += "fixed pattern   none\n";
    return;
  }
  double squares = 0;
  for (const double value : pattern) {
    squares += value * value;
  }
  const double unit = calibration.model.turn_m * kMm;
  const auto [least, most] = std::ranges::minmax(pattern);
  text += printed("fixed pattern   rms %.2f mm, %.1f to %.1f mm%s\n",
                  std::sqrt(squares / static_cast<double>(pattern.size())) * unit, least * unit,
                  most * unit, calibration.parts.pattern ? "" : ", kept");
}

void add_stray(const PmdCalibration& calibration, std::string& text) {
  const StrayReport& stray = calibration.stray;
  const bool seen =
      stray.verdict == StrayVerdict::kCorrected || stray.verdict == StrayVerdict::kSuspected;
  if (seen) {
    text += printed(
        "stray light suspected: I %.1f, Q %.1f LSB (+- %.1f), as of a surface at %.2f m;\n"
        "                it explains %.1f %% of the misfit; %s\n",
        stray.estimate.real(), stray.estimate.imag(), stray.sigma, stray.apparent_m,
        stray.explains * kPercent,
        stray.verdict == StrayVerdict::kCorrected
            ? "subtracted from now on"
            : "NOT subtracted: distances are wrong, fit it too");
  } else if (calibration.model.stray != 0.0) {
    text += printed("stray light     I %.1f, Q %.1f LSB, kept\n", calibration.model.stray.real(),
                    calibration.model.stray.imag());
  } else {
    text += stray.verdict == StrayVerdict::kNone
                ? "stray light     none to be seen\n"
                : "stray light     unknown: takes walls at four distances or more\n";
  }
}

void add_lights(const PmdCalibration& calibration, std::string& text) {
  const std::vector<dsp::Emitter>& lights = calibration.model.emitters;
  text += printed("lights          %s", lights.empty() ? "at the lens" : "");
  for (const dsp::Emitter& e : lights) {
    text += printed("(%.3f, %.3f, %.3f) ", e[0], e[1], e[2]);
  }
  if (!lights.empty()) {
    text += calibration.parts.emitter ? "m, estimated" : "m, as given";
  }
  text += '\n';
}

void add_wall_turn(const PmdCalibration& calibration, std::string& text) {
  if (calibration.parts.wall_turn) {
    const WallTurn& turn = calibration.model.wall_turn;
    text += printed(
        "walls           do not face the camera: turned sideways by %.2f, up and down by %.2f "
        "degrees, all alike; counted so\n",
        std::atan(turn[0]) * kDegrees, std::atan(turn[1]) * kDegrees);
  }
}

void add_noise(const PmdCalibration& calibration, std::string& text) {
  const SampleNoise& noise = calibration.noise;
  text += printed(
      "noise           %.1f electrons per LSB, %.2f LSB without light, suppressed light %.0f "
      "LSB%s\n",
      noise.electrons_per_lsb, noise.noise_lsb, noise.suppressed_lsb,
      calibration.noise_fitted ? "" : " (not measured: as before)");
  if (calibration.sigma) {
    text += printed(
        "                eq. 15: sigma = %.4f %+.6f z %+.3e z^2, cm (the chapter at 1, 2, 3, 4 m: "
        "0.52, 1.62, 3.28, 5.48)\n",
        calibration.sigma->a, calibration.sigma->b, calibration.sigma->c);
  }
}

}  // namespace

dataset::Loaded<PmdReport> make_report(const WallFolder& folder, Frames fitted,
                                       const PmdCalibration& calibration) {
  PmdReport report{.folder = {}, .fitted = fitted, .judged = others(fitted), .rows = {}};
  double worst_near = 0;
  bool far = false;
  for (std::size_t n = 0; n < folder.prefixes.size(); ++n) {
    const dataset::Loaded<WallRecording> wall = read_again(folder, n);
    if (!wall) {
      return std::unexpected(wall.error());
    }
    WallRow row{
        .name = wall->name,
        .z_m = wall->z_m,
        .exposure = wall->exposure,
        .line_error_m = std::nan(""),
        .view = view_wall(calibration.sensor, *wall, report.judged, calibration.model.wall_turn)};
    const Wall seen = summarise(*wall, report.judged);
    if (calibration.line && seen.frames > 0) {
      row.line_error_m = line_error(*calibration.line, calibration.data, calibration.model, seen);
    }
    const double relative = std::abs(row.view.error_m) / row.z_m;
    if (std::isfinite(relative)) {
      double& worst = row.z_m >= kLineFromM ? report.worst_relative : worst_near;
      worst = std::max(worst, relative);
      far |= row.z_m >= kLineFromM;
    }
    report.rows.push_back(std::move(row));
  }
  std::ranges::sort(report.rows, {}, &WallRow::z_m);
  report.worst_relative = far ? report.worst_relative : worst_near;
  return report;
}

std::string wrong_walls_text(const std::vector<WrongWall>& walls) {
  std::string text;
  for (const WrongWall& wall : walls) {
    text += text.empty() ? "" : ", or else ";
    text += printed("%s is said to be at %.3f m, the other walls put it at %.3f m (+- %.3f)",
                    wall.name.c_str(), wall.z_m, wall.likely_m, wall.sigma_m);
  }
  return text;
}

std::string report_text(const PmdReport& report, const PmdCalibration& calibration) {
  const dsp::PmdSensor& sensor = calibration.sensor;
  std::string text;
  text +=
      printed("%s: %zu recordings of a wall, %dx%d sensor, %.4g MHz; fitted to %s, judged by %s\n",
              report.folder.c_str(), report.rows.size(), sensor.lens.width, sensor.lens.height,
              sensor.frequency.modulation.value / 1e6, in_words(report.fitted).c_str(),
              in_words(report.judged).c_str());
  text += "Z in the middle of the picture, mean over pixels and frames, less the wall's:\n\n";
  add_table(report, calibration, text);
  text += printed("\ncalibrated      at worst %.3f %% of walls from %.1f m on\n",
                  report.worst_relative * kPercent, kLineFromM);
  add_line(calibration, text);
  text +=
      printed("phase           of this camera %s with distance; offset %.1f mm%s; scale %.5f%s\n",
              calibration.model.phase_falls ? "falls" : "rises",
              calibration.model.offset * calibration.model.turn_m * kMm,
              calibration.parts.offset ? "" : ", kept", calibration.model.scale,
              calibration.parts.scale ? "" : " (the walls ask for no other)");
  add_wiggling(calibration, text);
  add_pattern(calibration, text);
  add_stray(calibration, text);
  add_lights(calibration, text);
  add_wall_turn(calibration, text);
  add_noise(calibration, text);
  text +=
      printed("white           a white surface at 1 m has amplitude %.0f LSB\n", sensor.white_lsb);
  text += printed(
      "misfit          %.2f standard deviations of %zu readings%s\n", calibration.misfit,
      calibration.readings,
      calibration.misfit <= kLargestMisfit ? "" : ": the model does not explain these walls");
  if (!calibration.wrong_walls.empty()) {
    text += "wrong wall      " + wrong_walls_text(calibration.wrong_walls) +
            printed("; explains %.0f %% of the misfit\n",
                    calibration.wrong_walls.front().explains * kPercent);
  }
  return text;
}

}  // namespace stof::host
