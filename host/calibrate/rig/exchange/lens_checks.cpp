#include "host/calibrate/rig/exchange/lens_checks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/files/file.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr const char* kFit = "calibrate with a pinhole and k1 k2 p1 p2 (plumb_bob, radtan)";
constexpr std::size_t kTaken = 5;
constexpr std::size_t kMostCoefficients = 14;

// What OpenCV's coefficient number n belongs to, beyond the first five.
std::string model_of(std::size_t n) {
  constexpr std::size_t kRational = 8;
  constexpr std::size_t kThinPrism = 12;
  if (n < kRational) {
    return "has a rational model";
  }
  return n < kThinPrism ? "has a thin prism model" : "has a tilted sensor";
}

}  // namespace

void require_radtan(YamlReader& reader, const YAML::Node& node) {
  const std::string model = reader.word(node, "distortion model");
  constexpr std::array kKnown{"plumb_bob", "radtan", "none"};
  if (!reader.failed() && std::ranges::find(kKnown, model) == kKnown.end()) {
    reader.fail(node, "has the distortion model " + model + ", which rectification does not know",
                kFit);
  }
}

void require_pinhole(YamlReader& reader, const YAML::Node& node) {
  const std::string model = reader.word(node, "camera model");
  if (!reader.failed() && model != "pinhole") {
    reader.fail(node, "has the camera model " + model + ", which rectification does not know",
                kFit);
  }
}

void put_distortion(YamlReader& reader, const YAML::Node& node, const char* name,
                    dsp::Pinhole& lens) {
  const std::vector<double> k = reader.numbers(node, name, 0, kMostCoefficients);
  if (reader.failed()) {
    return;
  }
  if (const auto more = std::find_if(k.begin() + kTaken, k.end(), [](double c) { return c != 0; });
      more != k.end()) {
    const auto at = static_cast<std::size_t>(more - k.begin());
    reader.fail(node,
                model_of(at) +
                    printed(" (coefficient %zu of %s is not 0), which rectification does not know",
                            at + 1, name),
                kFit);
    return;
  }
  lens.k1 = k[0];
  lens.k2 = k[1];
  lens.p1 = k[2];
  lens.p2 = k[3];
  lens.k3 = k[4];
}

void put_matrix(YamlReader& reader, const YAML::Node& node, const char* name, dsp::Pinhole& lens) {
  constexpr std::size_t kElements = 9;
  const std::vector<double> m = reader.numbers(node, name, kElements, kElements);
  if (reader.failed()) {
    return;
  }
  if (m[1] != 0 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1) {
    reader.fail(node, std::string("has a ") + name + " with skew, or that is no camera matrix",
                kFit);
    return;
  }
  lens.fx = m[0];
  lens.cx = m[2];
  lens.fy = m[4];
  lens.cy = m[5];
}

dataset::Loaded<dsp::RawPair> judged(const std::filesystem::path& file, const YamlReader& reader,
                                     const dsp::RawPair& rig) {
  if (reader.failed()) {
    return std::unexpected(reader.problem());
  }
  dsp::Calibration calibration;
  calibration.stereo.raw = rig;
  const char* why = dsp::complete(calibration.stereo);
  if (*why == '\0') {
    why = dsp::problem(calibration);
  }
  if (*why != '\0') {
    return dataset::refuse(file, why, "calibrate the rig anew");
  }
  return rig;
}

}  // namespace stof::host
