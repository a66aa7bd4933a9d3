#pragma once

#include <string>

#include "dataset/dataset.h"
#include "host/evaluate/fusion/fusion.h"
#include "host/evaluate/stereo/match.h"

namespace stof::host {

// A stereo pair with truth and a PMD recording of its scene by the same rig.
struct RecordedPair {
  dataset::StereoScene pair;
  dataset::PmdRecording recording;
  dataset::Image<float> depth;  // truth: Z in metres of the left view, +inf = unknown
};

// One line when a file is missing, has no truth or no rig.
dataset::Loaded<RecordedPair> read_recorded_pair(const std::filesystem::path& scene,
                                                 const std::filesystem::path& prefix);

// FusionOptions::camera. Refused is that of another camera (other_camera.h). The text says what is
// carried over to a picture of another size; empty where sizes agree.
dataset::Loaded<std::string> apply_calibration(const dsp::PmdSensor& found,
                                               const std::filesystem::path& prefix,
                                               dataset::PmdRecording& recording);

// A stereo pair with truth, its PMD recording, and what became of them.
struct FusionCase {
  std::string scene;      // name of the pair's folder
  std::string recording;  // the prefix without its folder
  dsp::Pinhole lens;      // of the PMD camera
  dsp::StereoRig rig;     // of the recording
  dataset::Image<std::uint8_t> left;
  dataset::Image<float> truth;  // Z in metres of the left view, +inf = unknown
  std::string note{};           // of apply_calibration()
  FusionResult result;
  FusionScores scores;

  std::string sensor() const;  // "64x16"
};

// Reads, fuses and scores. One line when a file is missing, has no truth or no rig, or when the
// options mean nothing.
dataset::Loaded<FusionCase> run_fusion_case(const std::filesystem::path& scene,
                                            const std::filesystem::path& prefix,
                                            const MatchRequest& match,
                                            const FusionOptions& options);

// "64x16", ... in the order they come.
std::vector<std::string> sensors_of(std::span<const FusionCase> cases);
// As mean_scores(); of all cases where `sensor` is empty.
FusionScores mean_of_sensor(std::span<const FusionCase> cases, const std::string& sensor);

}  // namespace stof::host
