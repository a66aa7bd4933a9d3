#include "dataset/calibration_truth.h"

#include "dataset/files/file.h"
#include "dataset/files/json_fields.h"

namespace stof::dataset {
namespace {

using nlohmann::ordered_json;

ordered_json lens_of(const dsp::Pinhole& lens) {
  ordered_json out{{"width", lens.width}, {"height", lens.height}};
  for (const NumberKey<dsp::Pinhole>& number : kLensKeys) {
    out[number.key] = lens.*number.value;
  }
  return out;
}

ordered_json transform_of(const dsp::RigidTransform& transform) {
  return {{"R", transform.rotation}, {"T", transform.translation_m}};
}

// Of the z axis and the translation.
double along_z(const dsp::RigidTransform& transform) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    sum += transform.rotation[3 * i + 2] * transform.translation_m[i];
  }
  return sum;
}

ordered_json pose_of(const PoseTruth& pose) {
  const std::array<double, 9>& r = pose.board_to_left.rotation;
  ordered_json out{{"folder", pose.folder}, {"kind", pose.kind}};
  out["board_to_left"] = transform_of(pose.board_to_left);
  // normal . X = distance for all points of the sheet; the normal points away from the camera.
  out["plane"] = {{"normal", {r[2], r[5], r[8]}}, {"distance_m", along_z(pose.board_to_left)}};
  out["velocity_m_s"] = pose.velocity_m_s;
  out["turn_degrees_s"] = pose.turn_degrees_s;
  out["seen_by"] = {
      {"left", pose.seen_by_left}, {"right", pose.seen_by_right}, {"pmd", pose.seen_by_pmd}};
  return out;
}

}  // namespace

std::expected<void, Problem> write_calibration_truth(const std::filesystem::path& file,
                                                     const CalibrationTruth& truth) {
  ordered_json root{{"version", 1}};
  root["left"] = lens_of(truth.left);
  root["right"] = lens_of(truth.right);
  root["left_to_right"] = transform_of(truth.left_to_right);
  root["left_to_rig"] = {{"R", truth.left_to_rig}};
  if (const auto& c = truth.converging) {
    root["converging"] = {{"alpha_rad", c->alpha_rad}, {"beta_rad", c->beta_rad},
                          {"f1_m", c->f1_m},           {"f2_m", c->f2_m},
                          {"pixel_m", c->pixel_m},     {"cx_left", c->cx_left},
                          {"cx_right", c->cx_right}};
  }
  if (truth.pmd) {
    root["pmd"] = lens_of(*truth.pmd);
    root["pmd_to_left"] = transform_of(truth.pmd_to_left);
  }
  root["blur_px"] = truth.blur_px;
  root["vignetting"] = truth.vignetting;
  root["pmd_blur_px"] = truth.pmd_blur_px;
  if (truth.board) {
    root["board"] = {{"kind", truth.board->kind},
                     {"columns", truth.board->columns},
                     {"rows", truth.board->rows},
                     {"square_m", truth.board->square_m}};
  }
  root["poses"] = ordered_json::array();
  for (const PoseTruth& pose : truth.poses) {
    root["poses"].push_back(pose_of(pose));
  }
  return write_whole(file, root.dump(1) + "\n");
}

}  // namespace stof::dataset
