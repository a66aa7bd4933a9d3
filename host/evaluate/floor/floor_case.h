#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/evaluate/floor/floor_score.h"
#include "host/evaluate/fusion/fusion.h"
#include "host/evaluate/stereo/match.h"

namespace stof::host {

// A depth map of a scene above a floor.
struct FloorDepth {
  const char* source;           // "stereo" alone or "fused"
  dataset::Image<float> depth;  // Z in metres, +inf = none
  FloorScore score;
};

// The results for such a scene, matched in one way.
struct FloorRun {
  std::string matcher;             // in words
  std::vector<FloorDepth> depths;  // fused only where there is a PMD recording
};

// A pair above a floor.
struct FloorCase {
  std::string scene;  // name of the folder
  double height_m = 0;
  double tilt_degrees = 0;
  dataset::Image<float> truth;  // Z in metres of the left view, +inf = unknown
  std::vector<FloorRun> runs;   // one for each matcher
};

// Reads the folder and its recording `pmd`, where there is one, fuses and scores. One line when a
// file is missing or says nothing of a floor, when the floor is not where the pose says, or when
// the options mean nothing.
dataset::Loaded<FloorCase> run_floor_case(const std::filesystem::path& folder,
                                          std::span<const MatchRequest> matchers,
                                          const FusionOptions& options);

// (depth - truth) / truth of each pixel; +inf where one of them is unknown.
dataset::Image<float> relative_error(const dataset::Image<float>& depth,
                                     const dataset::Image<float>& truth);

}  // namespace stof::host
