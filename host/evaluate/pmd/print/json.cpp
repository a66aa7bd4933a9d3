#include "host/evaluate/pmd/print/json.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "host/calibrate/report/pmd_json.h"
#include "host/evaluate/stereo/median.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using nlohmann::ordered_json;

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json share(long part, long whole) {
  return whole == 0 ? ordered_json(nullptr)
                    : ordered_json(static_cast<double>(part) / static_cast<double>(whole));
}

ordered_json flags_of(const WallView& view) {
  ordered_json flags = ordered_json::object();
  for (std::size_t bit = 0; bit < kPmdFlags; ++bit) {
    flags[pmd_flag_names()[bit]] = view.flagged[bit];
  }
  return flags;
}

ordered_json to_json(const WallStudy& study) {
  ordered_json out = ordered_json::parse(report_json(study.report, study.calibration));
  out["folder"] = study.folder.string();
  out["given_calibration"] = study.given;
  if (study.stray.empty()) {
    return out;
  }
  ordered_json rows = ordered_json::array();
  for (const StrayRow& row : study.stray) {
    rows.push_back({{"name", row.name},
                    {"z_m", row.z_m},
                    {"before_mm", number(row.before.error_m * kMm)},
                    {"before_valid", row.before.valid},
                    {"before_flags", flags_of(row.before)},
                    {"after_mm", number(row.after.error_m * kMm)},
                    {"after_valid", row.after.valid},
                    {"after_flags", flags_of(row.after)}});
  }
  out["stray_light_alone"] = {{"i_lsb", study.stray_i_lsb},
                              {"q_lsb", study.stray_q_lsb},
                              {"sigma_lsb", study.stray_sigma_lsb},
                              {"apparent_m", study.stray_apparent_m},
                              {"rows", rows}};
  return out;
}

ordered_json to_json(const LightStudy& study) {
  ordered_json rows = ordered_json::array();
  for (const LightRow& row : study.rows) {
    rows.push_back({{"name", row.name},
                    {"z_m", row.z_m},
                    {"before_mm", row.before_m * kMm},
                    {"after_mm", row.after_m * kMm},
                    {"before_blocks_mm", row.before_blocks_m * kMm},
                    {"after_blocks_mm", row.after_blocks_m * kMm},
                    {"pixels", row.pixels}});
  }
  return {{"folder", study.folder.string()}, {"rows", rows}};
}

ordered_json to_json(const EdgeCounts& c) {
  ordered_json out{{"mixed", c.mixed},
                   {"mixed_with_depth", c.mixed_with_depth},
                   {"mixed_flagged", share(c.mixed_flagged, c.mixed_with_depth)},
                   {"holds_both", share(c.holding, c.mixed_with_depth)},
                   {"worst_short_by_mm", c.worst_m * kMm},
                   {"worst_short_by_sigmas", c.worst_sigmas},
                   {"pure", c.pure},
                   {"pure_with_depth", c.pure_with_depth},
                   {"pure_flagged", share(c.pure_flagged, c.pure_with_depth)},
                   {"pure_beside_mixed", c.pure_beside},
                   {"pure_beside_mixed_flagged", share(c.pure_flagged_beside, c.pure_beside)}};
  if (!c.pure_error_m.empty()) {
    out["pure_median_error_mm"] = *median(c.pure_error_m) * kMm;
    out["pure_holds"] = share(c.pure_holding, c.pure_with_depth);
  }
  return out;
}

ordered_json to_json(const EdgeStudy& study) {
  ordered_json rows = ordered_json::array();
  for (const EdgeRow& row : study.rows) {
    ordered_json& added = rows.emplace_back(to_json(row.counts));
    added["name"] = row.name;
    if (std::isfinite(row.edge_m)) {
      added["x_edge_m"] = row.edge_m;
    }
  }
  return {{"folder", study.folder.string()}, {"rows", rows}, {"all", to_json(study.all)}};
}

ordered_json to_json(const FrequencyStudy& study) {
  ordered_json rows = ordered_json::array();
  for (const FrequencyRow& row : study.rows) {
    rows.push_back({{"name", row.name},
                    {"first_mhz", row.first_mhz},
                    {"second_mhz", row.second_mhz},
                    {"period_m", row.period_m},
                    {"nearest_m", row.nearest_m},
                    {"farthest_m", row.farthest_m},
                    {"min_modulation_ratio", row.min_ratio},
                    {"pixels", row.pixels},
                    {"accepted", row.accepted},
                    {"accepted_share", share(row.accepted, row.pixels)},
                    {"wrong_unwraps", row.wrong},
                    {"median_error_mm", number(row.median_error_m * kMm)}});
  }
  return {{"folder", study.folder.string()}, {"rows", rows}};
}

ordered_json to_json(const std::optional<CloudDifference>& difference) {
  if (!difference) {
    return nullptr;
  }
  return {{"largest_mm", difference->largest_m * kMm},
          {"median_mm", difference->median_m * kMm},
          {"pixels", difference->pixels}};
}

ordered_json to_json(const FrameStudy& frame) {
  return {{"folder", frame.folder.string()},
          {"width", frame.width},
          {"height", frame.height},
          {"valid", frame.valid},
          {"buffer", frame.buffer},
          {"buffer_has_cartesian", frame.has_cartesian},
          {"buffer_has_same_distances", frame.buffer && frame.same_distances},
          {"cloud_to_cameras", to_json(frame.camera)},
          {"cloud_to_double_precision", to_json(std::optional(frame.exact))},
          {"cloud_to_cameras_way_back", to_json(frame.way_back)},
          {"noise_rank_correlation", number(frame.rank_correlation)},
          {"noise_rank_correlation_as_given", number(frame.rank_correlation_as_given)},
          {"median_noise_mm", number(frame.median_noise_m * kMm)}};
}

template <typename Study>
ordered_json all_of(const std::vector<Study>& studies) {
  ordered_json out = ordered_json::array();
  for (const Study& study : studies) {
    out.push_back(to_json(study));
  }
  return out;
}

}  // namespace

std::string pmd_json(const PmdEvaluation& evaluation) {
  const ordered_json root{{"folder", evaluation.folder.string()},
                          {"phase",
                           {{"samples", evaluation.phase.pixels},
                            {"largest_error_lsb", evaluation.phase.largest_lsb},
                            {"mean_error_lsb", evaluation.phase.mean_lsb},
                            {"kernels_equal", evaluation.phase.kernels_equal}}},
                          {"walls", all_of(evaluation.walls)},
                          {"lights", all_of(evaluation.lights)},
                          {"edges", all_of(evaluation.edges)},
                          {"tones", all_of(evaluation.frequencies)},
                          {"scenes", all_of(evaluation.scenes)},
                          {"frames", all_of(evaluation.frames)},
                          {"notes", evaluation.notes}};
  return root.dump(2);
}

}  // namespace stof::host
