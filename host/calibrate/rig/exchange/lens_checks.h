#pragma once

#include <string>
#include <vector>

#include "dsp/calib/calibration.h"
#include "host/calibrate/rig/exchange/yaml_reader.h"

// What readers of all formats share.
namespace stof::host {

// Fails where the name of a distortion model is not one of k1 k2 p1 p2 (k3).
void require_radtan(YamlReader& reader, const YAML::Node& node);
// Fails where the name of a projection is not a pinhole's.
void require_pinhole(YamlReader& reader, const YAML::Node& node);

inline constexpr const char* kTakenModel =
    "calibrate with a pinhole and k1 k2 p1 p2 (plumb_bob, radtan)";
inline constexpr std::size_t kMostCoefficients = 14;  // of any model of OpenCV

// k1 k2 p1 p2 k3 ...: more than five are a rational model or more, unless they are zero. Empty, or
// what is wrong with the numbers that are called `name`; then the lens stays as it is.
std::string put_distortion(const std::vector<double>& k, const char* name, dsp::Pinhole& lens);
// fx 0 cx 0 fy cy 0 0 1; a skew is wrong.
std::string put_matrix(const std::vector<double>& m, const char* name, dsp::Pinhole& lens);
// Both from YAML, where what is wrong makes the reader fail.
void put_distortion(YamlReader& reader, const YAML::Node& node, const char* name,
                    dsp::Pinhole& lens);
void put_matrix(YamlReader& reader, const YAML::Node& node, const char* name, dsp::Pinhole& lens);

// What no lens may be, or empty.
std::string problem_of(const dsp::Pinhole& lens);
// Whether the centre lies in the picture.
bool is_centred(const dsp::Pinhole& lens);

// The pair, or what no pair may be (dsp::problem(), is_centred()).
dataset::Loaded<dsp::RawPair> judged(const std::filesystem::path& file, const dsp::RawPair& rig);

}  // namespace stof::host
