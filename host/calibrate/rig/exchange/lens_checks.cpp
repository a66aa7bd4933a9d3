#include "host/calibrate/rig/exchange/lens_checks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/files/file.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kTaken = 5;

// What OpenCV's coefficient number n belongs to, beyond the first five.
std::string model_of(std::size_t n) {
  constexpr std::size_t kRational = 8;
  constexpr std::size_t kThinPrism = 12;
  if (n < kRational) {
    return "has a rational model";
  }
  return n < kThinPrism ? "has a thin prism model" : "has a tilted sensor";
}

// Of a pair, or "".
const char* problem_of(const dsp::RawPair& rig) {
  dsp::Calibration calibration;
  calibration.stereo.raw = rig;
  const char* const why = dsp::complete(calibration.stereo);
  return *why == '\0' ? dsp::problem(calibration) : why;
}

}  // namespace

void require_radtan(YamlReader& reader, const YAML::Node& node) {
  const std::string model = reader.word(node, "distortion model");
  constexpr std::array kKnown{"plumb_bob", "radtan", "none"};
  if (!reader.failed() && std::ranges::find(kKnown, model) == kKnown.end()) {
    reader.fail(node, "has the distortion model " + model + ", which rectification does not know",
                kTakenModel);
  }
}

void require_pinhole(YamlReader& reader, const YAML::Node& node) {
  const std::string model = reader.word(node, "camera model");
  if (!reader.failed() && model != "pinhole") {
    reader.fail(node, "has the camera model " + model + ", which rectification does not know",
                kTakenModel);
  }
}

std::string put_distortion(const std::vector<double>& k, const char* name, dsp::Pinhole& lens) {
  std::array<double, kTaken> taken{};
  for (std::size_t i = 0; i < k.size(); ++i) {
    if (i < kTaken) {
      taken[i] = k[i];
    } else if (k[i] != 0) {
      return model_of(i) + printed(
                               " (coefficient %zu of %s is not 0), which rectification does "
                               "not know",
                               i + 1, name);
    }
  }
  lens.k1 = taken[0];
  lens.k2 = taken[1];
  lens.p1 = taken[2];
  lens.p2 = taken[3];
  lens.k3 = taken[4];
  return {};
}

std::string put_matrix(const std::vector<double>& m, const char* name, dsp::Pinhole& lens) {
  if (m[1] != 0 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1) {
    return std::string("has a ") + name + " with skew, or that is no camera matrix";
  }
  lens.fx = m[0];
  lens.cx = m[2];
  lens.fy = m[4];
  lens.cy = m[5];
  return {};
}

void put_distortion(YamlReader& reader, const YAML::Node& node, const char* name,
                    dsp::Pinhole& lens) {
  const std::vector<double> k = reader.numbers(node, name, 0, kMostCoefficients);
  const std::string wrong = reader.failed() ? "" : put_distortion(k, name, lens);
  if (!wrong.empty()) {
    reader.fail(node, wrong, kTakenModel);
  }
}

void put_matrix(YamlReader& reader, const YAML::Node& node, const char* name, dsp::Pinhole& lens) {
  constexpr std::size_t kElements = 9;
  const std::vector<double> m = reader.numbers(node, name, kElements, kElements);
  const std::string wrong = reader.failed() ? "" : put_matrix(m, name, lens);
  if (!wrong.empty()) {
    reader.fail(node, wrong, kTakenModel);
  }
}

dataset::Loaded<NamedText> read_text(const std::filesystem::path& file) {
  constexpr std::size_t kMaxBytes = 1U << 20;
  dataset::Loaded<std::string> text = dataset::read_whole(file, kMaxBytes);
  if (!text) {
    return std::unexpected(std::move(text.error()));
  }
  return NamedText{file, std::move(*text)};
}

bool is_centred(const dsp::Pinhole& lens) {
  return lens.cx >= 0 && lens.cx <= lens.width - 1 && lens.cy >= 0 && lens.cy <= lens.height - 1;
}

std::string problem_of(const dsp::Pinhole& lens) {
  // As both eyes of a pair that has nothing else to be wrong.
  dsp::RawPair pair{.left = lens, .right = lens, .left_to_right = {}};
  pair.left_to_right.translation_m = {-1, 0, 0};
  if (const char* const why = problem_of(pair); *why != '\0') {
    return why;
  }
  if (!is_centred(lens)) {
    return printed("has its centre at %.1f, %.1f, outside of the picture of %dx%d", lens.cx,
                   lens.cy, lens.width, lens.height);
  }
  return {};
}

dataset::Loaded<dsp::RawPair> judged(const std::filesystem::path& file, const dsp::RawPair& rig) {
  if (const char* const why = problem_of(rig); *why != '\0') {
    return dataset::refuse(file, why, "calibrate the rig anew");
  }
  for (const dsp::Pinhole& lens : {rig.left, rig.right}) {
    if (const std::string wrong = problem_of(lens); !wrong.empty()) {
      return dataset::refuse(file, wrong, "give the size of the calibrated pictures");
    }
  }
  return rig;
}

}  // namespace stof::host
