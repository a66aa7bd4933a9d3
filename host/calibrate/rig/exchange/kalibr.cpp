#include "dataset/files/file.h"
#include "host/calibrate/rig/exchange/exchange.h"
#include "host/calibrate/rig/exchange/lens_checks.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kCoefficients = 4;

dsp::Pinhole lens_of(YamlReader& reader, const YAML::Node& camera) {
  dsp::Pinhole lens;
  require_pinhole(reader, reader.in(camera, "camera_model"));
  require_radtan(reader, reader.in(camera, "distortion_model"));
  const std::vector<double> f = reader.numbers(reader.in(camera, "intrinsics"), "intrinsics", 4, 4);
  const YAML::Node distortion = reader.in(camera, "distortion_coeffs");
  put_distortion(reader, distortion, "distortion_coeffs", lens);
  if (!reader.failed() && distortion.size() > kCoefficients) {
    reader.fail(distortion,
                printed("has %zu distortion_coeffs; radtan of Kalibr has %zu: k1 k2 p1 p2",
                        distortion.size(), kCoefficients),
                "export it again, or give a ROS or OpenCV file, which may have k3");
  }
  const YAML::Node size = reader.in(camera, "resolution");
  if (!reader.failed() && (!size.IsSequence() || size.size() != 2)) {
    reader.fail(size, "has a resolution that is no [width, height]", "export it again");
  }
  if (reader.failed()) {
    return lens;
  }
  lens.width = reader.integer(size[0], "resolution");
  lens.height = reader.integer(size[1], "resolution");
  lens.fx = f[0];
  lens.fy = f[1];
  lens.cx = f[2];
  lens.cy = f[3];
  return lens;
}

std::string camera_text(const char* name, const dsp::Pinhole& lens) {
  return printed(
      "%s:\n  camera_model: pinhole\n  intrinsics: %s\n  distortion_model: radtan\n"
      "  distortion_coeffs: %s\n  resolution: [%d, %d]\n",
      name, exact_list({lens.fx, lens.fy, lens.cx, lens.cy}).c_str(),
      exact_list({lens.k1, lens.k2, lens.p1, lens.p2}).c_str(), lens.width, lens.height);
}

}  // namespace

dataset::Loaded<dsp::RawPair> parse_kalibr(const NamedText& text) {
  dataset::Loaded<YamlReader> reader = YamlReader::of(text);
  if (!reader) {
    return std::unexpected(std::move(reader.error()));
  }
  dsp::RawPair rig;
  rig.left = lens_of(*reader, reader->at("cam0"));
  const YAML::Node right = reader->at("cam1");
  if (reader->has("cam2")) {
    reader->fail(reader->at("cam2"), "has a third camera",
                 "leave cam0, the left one, and cam1, the right one");
  }
  rig.right = lens_of(*reader, right);
  const std::vector<double> m = reader->rows(reader->in(right, "T_cn_cnm1"), "T_cn_cnm1", 4, 4);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      rig.left_to_right.rotation[3 * i + j] = m[4 * i + j];
    }
    rig.left_to_right.translation_m[i] = m[4 * i + 3];
  }
  return reader->failed() ? std::unexpected(reader->problem()) : judged(text.file, rig);
}

dataset::Loaded<std::string> kalibr_text(const dsp::RawPair& rig) {
  if (rig.left.k3 != 0 || rig.right.k3 != 0) {
    return dataset::refuse(
        "this pair has k3, which Kalibr's radtan does not: export it as ros or opencv");
  }
  std::string text = camera_text("cam0", rig.left) + camera_text("cam1", rig.right);
  text += "  T_cn_cnm1:\n";
  for (std::size_t i = 0; i < 3; ++i) {
    const double* const r = &rig.left_to_right.rotation[3 * i];
    text += "  - " + exact_list({r[0], r[1], r[2], rig.left_to_right.translation_m[i]}) + "\n";
  }
  return text + "  - [0.0, 0.0, 0.0, 1.0]\n";
}

}  // namespace stof::host
