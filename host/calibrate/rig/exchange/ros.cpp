#include <array>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/LU>

#include "dataset/files/file.h"
#include "dsp/calib/stereo/rectification.h"
#include "host/calibrate/rig/exchange/exchange.h"
#include "host/calibrate/rig/exchange/lens_checks.h"
#include "host/calibrate/rig/exchange/ros_ini.h"
#include "host/calibrate/rig/target/lens_model.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// Of one eye: its lens, R into rectified axes, what P shifts by in those, and the lens of P.
struct CameraInfo {
  dsp::Pinhole lens;
  RowMatrix turn = RowMatrix::Identity();
  Vector3 shift = Vector3::Zero();
  double fx = 0;
  double fy = 0;
  double cy = 0;
  std::filesystem::path file;
  int projection_line = 0;
};

constexpr double kSameFocal = 1e-3;  // share; files may round
constexpr double kSameRowPx = 0.1;

constexpr const char* kNoFocalLength = "has a projection matrix without a focal length";
constexpr const char* kRemedy = "calibrate the pair";

// R and P. False where P has no focal length.
bool put_rectification(const std::vector<double>& turn, const std::vector<double>& p,
                       CameraInfo& info) {
  if (!(p[0] > 0) || !(p[5] > 0)) {
    return false;
  }
  info.turn = Eigen::Map<const RowMatrix>(turn.data());
  info.shift = {p[3] / p[0], p[7] / p[5], 0};
  info.fx = p[0];
  info.fy = p[5];
  info.cy = p[6];
  return true;
}

bool is_rotation(const RowMatrix& turn) {
  constexpr double kSlack = 1e-3;
  return (turn * turn.transpose() - RowMatrix::Identity()).cwiseAbs().maxCoeff() <= kSlack &&
         turn.determinant() > 0;
}

constexpr const char* kNoRotation = "has a rectification matrix that is no rotation";

// Rectified pictures have one focal length, and rows that correspond.
std::string contradiction(const CameraInfo& left, const CameraInfo& right) {
  const std::string of_left = " in " + left.file.string();
  if (std::abs(right.fx - left.fx) > kSameFocal * left.fx ||
      std::abs(right.fy - left.fy) > kSameFocal * left.fy) {
    return printed(
               "has a projection matrix with focal lengths of %g and %g px, which are %g and %g",
               right.fx, right.fy, left.fx, left.fy) +
           of_left;
  }
  if (std::abs(right.cy - left.cy) > kSameRowPx) {
    return printed("has a projection matrix whose centre is in row %g, which is %g", right.cy,
                   left.cy) +
           of_left;
  }
  return {};
}

dataset::Loaded<CameraInfo> info_of(YamlReader reader) {
  CameraInfo info;
  info.lens.width = reader.integer(reader.at("image_width"), "image_width");
  info.lens.height = reader.integer(reader.at("image_height"), "image_height");
  require_radtan(reader, reader.at("distortion_model"));
  put_matrix(reader, reader.at("camera_matrix"), "camera_matrix", info.lens);
  put_distortion(reader, reader.at("distortion_coefficients"), "distortion_coefficients",
                 info.lens);
  info.file = reader.file();
  if (const std::string wrong = reader.failed() ? "" : problem_of(info.lens); !wrong.empty()) {
    reader.fail(reader.at("camera_matrix"), wrong, kRemedy);
  }
  const YAML::Node rectification = reader.at("rectification_matrix");
  const std::vector<double> turn = reader.numbers(rectification, "rectification_matrix", 9, 9);
  const YAML::Node projection = reader.at("projection_matrix");
  const std::vector<double> p = reader.numbers(projection, "projection_matrix", 12, 12);
  if (!reader.failed() && !put_rectification(turn, p, info)) {
    reader.fail(projection, kNoFocalLength, kRemedy);
  }
  if (!reader.failed() && !is_rotation(info.turn)) {
    reader.fail(rectification, kNoRotation, kRemedy);
  }
  info.projection_line = reader.failed() ? 0 : projection.Mark().line + 1;
  return reader.failed() ? std::unexpected(reader.problem()) : dataset::Loaded<CameraInfo>(info);
}

dataset::Loaded<CameraInfo> info_of(const std::filesystem::path& file, const IniCamera& camera) {
  CameraInfo info;
  info.lens.width = camera.width;
  info.lens.height = camera.height;
  const auto wrong = [&](int line, const std::string& what, const char* remedy) {
    return dataset::refuse(file, printed("line %d: ", line) + what, remedy);
  };
  if (const std::string what = put_matrix(camera.matrix.numbers, "camera matrix", info.lens);
      !what.empty()) {
    return wrong(camera.matrix.line, what, kTakenModel);
  }
  if (const std::string what = put_distortion(camera.distortion.numbers, "distortion", info.lens);
      !what.empty()) {
    return wrong(camera.distortion.line, what, kTakenModel);
  }
  if (const std::string what = problem_of(info.lens); !what.empty()) {
    return wrong(camera.matrix.line, what, kRemedy);
  }
  if (!put_rectification(camera.rectification.numbers, camera.projection.numbers, info)) {
    return wrong(camera.projection.line, kNoFocalLength, kRemedy);
  }
  if (!is_rotation(info.turn)) {
    return wrong(camera.rectification.line, kNoRotation, kRemedy);
  }
  info.file = file;
  info.projection_line = camera.projection.line;
  return info;
}

// The cameras of one text.
dataset::Loaded<std::vector<CameraInfo>> infos_of(const NamedText& text) {
  std::vector<CameraInfo> infos;
  if (!is_ini(text.text)) {
    dataset::Loaded<YamlReader> reader = YamlReader::of(text);
    if (!reader) {
      return std::unexpected(std::move(reader.error()));
    }
    dataset::Loaded<CameraInfo> info = info_of(std::move(*reader));
    if (!info) {
      return std::unexpected(std::move(info.error()));
    }
    infos.push_back(*info);
    return infos;
  }
  const dataset::Loaded<std::vector<IniCamera>> cameras = parse_ini(text);
  if (!cameras) {
    return std::unexpected(cameras.error());
  }
  for (const IniCamera& camera : *cameras) {
    dataset::Loaded<CameraInfo> info = info_of(text.file, camera);
    if (!info) {
      return std::unexpected(std::move(info.error()));
    }
    infos.push_back(*info);
  }
  return infos;
}

std::string matrix_text(const char* name, int rows, int columns, const std::vector<double>& data) {
  return printed("%s:\n  rows: %d\n  cols: %d\n  data: %s\n", name, rows, columns,
                 exact_list(data).c_str());
}

}  // namespace

dataset::Loaded<dsp::RawPair> parse_ros(const std::vector<NamedText>& texts) {
  std::vector<CameraInfo> infos;
  for (const NamedText& text : texts) {
    const dataset::Loaded<std::vector<CameraInfo>> more = infos_of(text);
    if (!more) {
      return std::unexpected(more.error());
    }
    infos.insert(infos.end(), more->begin(), more->end());
  }
  const std::filesystem::path& file = texts.back().file;
  if (infos.size() != 2) {
    return dataset::refuse(
        file, printed("makes %zu cameras in all, not a left and a right one", infos.size()),
        "give left.yaml and right.yaml, or one INI file with both");
  }
  const CameraInfo& l = infos[0];
  const CameraInfo& r = infos[1];
  if (const std::string what = contradiction(l, r); !what.empty()) {
    return dataset::refuse(r.file, printed("line %d: ", r.projection_line) + what, kRemedy);
  }
  dsp::RawPair rig{.left = l.lens, .right = r.lens, .left_to_right = {}};
  const Matrix3 turn = r.turn.transpose() * l.turn;
  const Vector3 shift = r.turn.transpose() * (r.shift - l.shift);
  Eigen::Map<RowMatrix>(rig.left_to_right.rotation.data()) = turn;
  Eigen::Map<Vector3>(rig.left_to_right.translation_m.data()) = shift;
  return judged(file, rig);
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
