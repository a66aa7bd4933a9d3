#include <array>

#include <Eigen/Core>

#include "dsp/calib/stereo/rectification.h"
#include "host/calibrate/rig/exchange/exchange.h"
#include "host/calibrate/rig/exchange/lens_checks.h"
#include "host/calibrate/rig/target/lens_model.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct CameraInfo {
  dsp::Pinhole lens;
  RowMatrix turn = RowMatrix::Identity();  // R, into rectified axes
  Vector3 shift = Vector3::Zero();         // of rectified axes, from P
};

CameraInfo info_of(YamlReader& reader) {
  CameraInfo info;
  info.lens.width = reader.integer(reader.at("image_width"), "image_width");
  info.lens.height = reader.integer(reader.at("image_height"), "image_height");
  require_radtan(reader, reader.at("distortion_model"));
  put_matrix(reader, reader.at("camera_matrix"), "camera_matrix", info.lens);
  put_distortion(reader, reader.at("distortion_coefficients"), "distortion_coefficients",
                 info.lens);
  const std::vector<double> turn =
      reader.numbers(reader.at("rectification_matrix"), "rectification_matrix", 9, 9);
  const YAML::Node projection = reader.at("projection_matrix");
  const std::vector<double> p = reader.numbers(projection, "projection_matrix", 12, 12);
  if (!reader.failed() && (!(p[0] > 0) || !(p[5] > 0))) {
    reader.fail(projection, "has a projection_matrix without a focal length", "calibrate the pair");
  }
  if (!reader.failed()) {
    info.turn = Eigen::Map<const RowMatrix>(turn.data());
    info.shift = {p[3] / p[0], p[7] / p[5], 0};
  }
  return info;
}

std::string matrix_text(const char* name, int rows, int columns, const std::vector<double>& data) {
  return printed("%s:\n  rows: %d\n  cols: %d\n  data: %s\n", name, rows, columns,
                 exact_list(data).c_str());
}

}  // namespace

dataset::Loaded<dsp::RawPair> read_ros(const std::filesystem::path& left,
                                       const std::filesystem::path& right) {
  dataset::Loaded<YamlReader> of_left = YamlReader::open(left);
  if (!of_left) {
    return std::unexpected(std::move(of_left.error()));
  }
  dataset::Loaded<YamlReader> of_right = YamlReader::open(right);
  if (!of_right) {
    return std::unexpected(std::move(of_right.error()));
  }
  const CameraInfo l = info_of(*of_left);
  const CameraInfo r = info_of(*of_right);
  if (of_left->failed()) {
    return std::unexpected(of_left->problem());
  }
  dsp::RawPair rig{.left = l.lens, .right = r.lens, .left_to_right = {}};
  const Matrix3 turn = r.turn.transpose() * l.turn;
  const Vector3 shift = r.turn.transpose() * (r.shift - l.shift);
  Eigen::Map<RowMatrix>(rig.left_to_right.rotation.data()) = turn;
  Eigen::Map<Vector3>(rig.left_to_right.translation_m.data()) = shift;
  return judged(right, *of_right, rig);
}

std::string ros_text(const dsp::RawPair& rig, bool right) {
  const dsp::Pinhole& lens = right ? rig.right : rig.left;
  const dsp::Rectification rectified = dsp::rectify(rig);
  const dsp::Pinhole& to = right ? rectified.right : rectified.left;
  const std::array<double, 9>& turn = right ? rectified.right_turn : rectified.left_turn;
  std::string text = printed("image_width: %d\nimage_height: %d\ncamera_name: %s\n", lens.width,
                             lens.height, right ? "right" : "left");
  text += matrix_text("camera_matrix", 3, 3, {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1});
  text += "distortion_model: plumb_bob\n";
  text +=
      matrix_text("distortion_coefficients", 1, 5, {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3});
  text += matrix_text("rectification_matrix", 3, 3, {turn.begin(), turn.end()});
  text += matrix_text(
      "projection_matrix", 3, 4,
      {to.fx, 0, to.cx, right ? -to.fx * rectified.baseline_m : 0, 0, to.fy, to.cy, 0, 0, 0, 1, 0});
  return text;
}

}  // namespace stof::host
