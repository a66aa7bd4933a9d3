#include "host/cli/rig/stereo_json.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "host/calibrate/rig/report/rig_report.h"
#include "host/calibrate/rig/target/lens_model.h"
#include "host/cli/json_output.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

constexpr double kPercents = 100;

ordered_json lens_json(const dsp::Pinhole& lens) {
  const LensUnknowns numbers = unknowns_of(lens);
  ordered_json json;
  for (std::size_t i = 0; i < kLensUnknowns; ++i) {
    json[kLensNames[i]] = numbers[i];
  }
  return json;
}

ordered_json names_of(const auto& views) {
  ordered_json names = ordered_json::array();
  for (const auto& view : views) {
    names.push_back(view.name);
  }
  return names;
}

ordered_json chapter_json(const PlaneCalibration::Chapter& chapter) {
  return {
      {"genes_rms_mm", chapter.genes.rms_m * kMmPerMetre},
      {"genes_at_absolute_columns_rms_mm", number_or_null(chapter.elsewhere_rms_m * kMmPerMetre)},
      {"table2_rms_mm", number_or_null(chapter.table2_rms_m * kMmPerMetre)},
      {"table2_best_rms_mm", number_or_null(chapter.table2_best_rms_m * kMmPerMetre)},
      {"table2_best_offset_px", chapter.best_offset_px},
      {"refined_rms_mm", number_or_null(chapter.refined_rms_m * kMmPerMetre)}};
}

std::vector<std::string> warnings_of(const TargetCalibration& found) {
  std::vector<std::string> warnings = found.missing;
  for (std::string& line : notes_of(found)) {
    warnings.push_back(std::move(line));
  }
  if (!found.judgement) {
    warnings.emplace_back("no view was held out: nobody judges this calibration");
  }
  for (const RefusedView& view : found.refused) {
    warnings.push_back(view.name + " was left out: " + view.why);
  }
  return warnings;
}

}  // namespace

ordered_json matrix_json(const Eigen::MatrixXd& matrix) {
  ordered_json rows = ordered_json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    ordered_json row = ordered_json::array();
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
      row.push_back(matrix(i, k));
    }
    rows.push_back(row);
  }
  return rows;
}

ordered_json target_json(const CalibStereoOptions& options, const std::filesystem::path& folder,
                         const TargetCalibration& found) {
  const PairFit& fit = found.fit;
  const auto& [x, y, z] = fit.rig.left_to_right.translation_m;
  std::array<double, kRigUnknowns> sigma{};
  for (std::size_t i = 0; i < kRigUnknowns; ++i) {
    sigma[i] = fit.sigma(i);
  }
  ordered_json json{{"file", options.out.string()},
                    {"folder", folder.string()},
                    {"board", options.board},
                    {"left", lens_json(fit.rig.left)},
                    {"right", lens_json(fit.rig.right)},
                    {"rotation", fit.rig.left_to_right.rotation},
                    {"translation_m", fit.rig.left_to_right.translation_m},
                    {"baseline_m", std::hypot(x, y, z)},
                    {"sigma", sigma},
                    {"covariance", matrix_json(fit.covariance)},
                    {"corner_sigma_px", fit.corner_sigma_px},
                    {"views", names_of(found.fitted)}};
  json["held_out"] = nullptr;
  if (found.judgement) {
    const TargetJudgement& judgement = *found.judgement;
    json["held_out"] = {{"views", names_of(found.held_out)},
                        {"reprojection_px", judgement.reprojection_px},
                        {"row_px", judgement.row_px},
                        {"largest_row_px", judgement.largest_row_px},
                        {"scale_error", judgement.scale_error}};
  }
  json["left_out"] = ordered_json::array();
  for (const RefusedView& view : found.refused) {
    json["left_out"].push_back(view.name + ": " + view.why);
  }
  json["missing"] = found.missing;
  json["warnings"] = warnings_of(found);
  return json;
}

ordered_json planes_json(const CalibStereoOptions& options, const PlaneCalibration& found) {
  const PlaneFit& fit = found.fit;
  std::array<double, kPlaneUnknowns> sigma{};
  ordered_json told = ordered_json::array();
  for (std::size_t i = 0; i < kPlaneUnknowns; ++i) {
    sigma[i] = fit.sigma(i);
    told.push_back(number_or_null(fit.from_prior[i]));
  }
  ordered_json json{
      {"file", options.out.string()},
      {"folder", options.planes.string()},
      {"baseline_m", fit.x[0]},
      {"alpha_rad", fit.x[1]},
      {"beta_rad", fit.x[2]},
      {"f1_m", fit.x[3]},
      {"f2_m", fit.x[4]},
      {"sigma", sigma},
      {"told_sigma", told},
      {"covariance", matrix_json(fit.covariance)},
      {"constant_m2", triangulation_constant(fit.x)},
      {"constant_sigma_m2", fit.constant_sigma},
      {"difference_rad", fit.x[1] - fit.x[2]},
      {"difference_sigma_rad", fit.difference_sigma},
      {"axes_meet_m", number_or_null(zero_disparity_m(fit.x))},
      {"cell_sigma_px", fit.cell_sigma_px},
      {"genes_rms_mm", found.genes.rms_m * kMmPerMetre},
      {"genes_s", found.genes.seconds},
      {"refined_rms_mm", found.refined_rms_m * kMmPerMetre},
      {"spread_mm", number_or_null(pooled_spread_m(found.walls, true) * kMmPerMetre)},
      {"held_out_mm", number_or_null(pooled_spread_m(found.walls, false) * kMmPerMetre)}};
  json["walls"] = ordered_json::array();
  for (const WallJudgement& wall : found.walls) {
    json["walls"].push_back({{"name", wall.name},
                             {"z_m", wall.z_m},
                             {"spread_mm", wall.spread_m * kMmPerMetre},
                             {"bias_mm", wall.bias_m * kMmPerMetre},
                             {"depths", wall.pixels},
                             {"dropped", wall.dropped},
                             {"fitted", wall.fitted}});
  }
  json["chapter"] = found.chapter ? chapter_json(*found.chapter) : ordered_json(nullptr);
  return json;
}

}  // namespace stof::host
