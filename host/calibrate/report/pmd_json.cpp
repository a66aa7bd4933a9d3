#include "host/calibrate/report/pmd_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "host/text/printed.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

ordered_json number(double value, double unit = 1) {
  return std::isfinite(value) ? ordered_json(value * unit) : ordered_json(nullptr);
}

const char* name_of(StrayVerdict verdict) {
  switch (verdict) {
    case StrayVerdict::kNone:
      return "none";
    case StrayVerdict::kCorrected:
      return "subtracted";
    case StrayVerdict::kSuspected:
      return "suspected";
    default:
      return "unknown";
  }
}

ordered_json walls_of(const PmdReport& report, const PmdCalibration& calibration) {
  ordered_json walls = ordered_json::array();
  for (const WallRow& row : report.rows) {
    const double polynomial =
        calibration.sigma ? sigma_at(*calibration.sigma, row.z_m) : std::nan("");
    walls.push_back({{"name", row.name},
                     {"z_m", row.z_m},
                     {"exposure", row.exposure},
                     {"line_error_mm", number(row.line_error_m, kMm)},
                     {"error_mm", number(row.view.error_m, kMm)},
                     {"valid", row.view.valid},
                     {"sigma_measured_mm", number(row.view.spread_m, kMm)},
                     {"sigma_model_mm", number(row.view.predicted_m, kMm)},
                     {"sigma_eq15_mm", number(polynomial, kMm)}});
  }
  return walls;
}

ordered_json line_of(const PmdCalibration& calibration) {
  if (!calibration.line) {
    return nullptr;
  }
  const LineFit& line = *calibration.line;
  return {{"a", line.a},
          {"b_m", line.b_m},
          {"worst_relative", line.worst_relative},
          {"from_m", line.from_m},
          {"chapter_slope_cm", line.slope_cm},
          {"chapter_intercept_cm", line.intercept_cm}};
}

ordered_json wrong_walls_of(const PmdCalibration& calibration) {
  ordered_json walls = ordered_json::array();
  for (const WrongWall& wall : calibration.wrong_walls) {
    walls.push_back({{"name", wall.name},
                     {"z_m", wall.z_m},
                     {"likely_m", wall.likely_m},
                     {"sigma_m", wall.sigma_m},
                     {"explains", wall.explains}});
  }
  return walls;
}

}  // namespace

std::string report_json(const PmdReport& report, const PmdCalibration& calibration) {
  const dsp::PmdSensor& sensor = calibration.sensor;
  const StrayReport& stray = calibration.stray;
  ordered_json lights = ordered_json::array();
  for (const dsp::Emitter& light : calibration.model.emitters) {
    lights.push_back(light);
  }
  ordered_json polynomial = nullptr;
  if (calibration.sigma) {
    polynomial = {calibration.sigma->a, calibration.sigma->b, calibration.sigma->c};
  }
  const bool seen =
      stray.verdict == StrayVerdict::kCorrected || stray.verdict == StrayVerdict::kSuspected;
  const ordered_json root{{"folder", report.folder},
                          {"width", sensor.lens.width},
                          {"height", sensor.lens.height},
                          {"f_mod_hz", sensor.frequency.modulation.value},
                          {"fitted", to_string(report.fitted)},
                          {"judged", to_string(report.judged)},
                          {"walls", walls_of(report, calibration)},
                          {"worst_relative", report.worst_relative},
                          {"line", line_of(calibration)},
                          {"phase_falls", sensor.phase_falls},
                          {"offset_m", sensor.frequency.offset_m},
                          {"scale", sensor.scale},
                          {"shift_m", sensor.shift_m},
                          {"wiggling", sensor.frequency.wiggling},
                          {"widest_gap_turns", calibration.widest_gap},
                          {"stray_suspected", seen},
                          {"stray",
                           {{"verdict", name_of(stray.verdict)},
                            {"i_lsb", stray.estimate.real()},
                            {"q_lsb", stray.estimate.imag()},
                            {"sigma_lsb", stray.sigma},
                            {"apparent_m", stray.apparent_m}}},
                          {"stray_i_lsb", sensor.frequency.stray_i_lsb},
                          {"stray_q_lsb", sensor.frequency.stray_q_lsb},
                          {"emitters", lights},
                          {"wall_turn", calibration.model.wall_turn},
                          {"electrons_per_lsb", sensor.electrons_per_lsb},
                          {"noise_lsb", sensor.noise_lsb},
                          {"suppressed_lsb", sensor.suppressed_lsb},
                          {"noise_measured", calibration.noise_fitted},
                          {"sigma_polynomial_cm", polynomial},
                          {"white_lsb", sensor.white_lsb},
                          {"misfit", calibration.misfit},
                          {"wrong_walls", wrong_walls_of(calibration)}};
  return root.dump(2);
}

}  // namespace stof::host
