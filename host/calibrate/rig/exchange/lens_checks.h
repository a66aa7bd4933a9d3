#pragma once

#include "dsp/calib/calibration.h"
#include "host/calibrate/rig/exchange/yaml_reader.h"

// What readers of all formats share.
namespace stof::host {

// Fails where the name of a distortion model is not one of k1 k2 p1 p2 (k3).
void require_radtan(YamlReader& reader, const YAML::Node& node);
// Fails where the name of a projection is not a pinhole's.
void require_pinhole(YamlReader& reader, const YAML::Node& node);

// k1 k2 p1 p2 k3 ...: more than five are a rational model or more, unless they are zero.
void put_distortion(YamlReader& reader, const YAML::Node& node, const char* name,
                    dsp::Pinhole& lens);
// fx 0 cx 0 fy cy 0 0 1; a skew is refused.
void put_matrix(YamlReader& reader, const YAML::Node& node, const char* name, dsp::Pinhole& lens);

// The pair, or what the reader has to say, or what no pair may be (dsp::problem()).
dataset::Loaded<dsp::RawPair> judged(const std::filesystem::path& file, const YamlReader& reader,
                                     const dsp::RawPair& rig);

}  // namespace stof::host
