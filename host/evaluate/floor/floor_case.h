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

// The result for a scene above a floor, matched in one way.
struct FloorRun {
  std::string matcher;           // in words
  dataset::Image<float> stereo;  // Z in metres, +inf = none
  dataset::Image<float> fused;
  FloorScore stereo_score;
  FloorScore fused_score;
};

// A pair above a floor, with its PMD recording.
struct FloorCase {
  std::string scene;  // name of the folder
  double height_m = 0;
  double tilt_degrees = 0;
  dataset::Image<float> truth;  // Z in metres of the left view, +inf = unknown
  std::vector<FloorRun> runs;   // one for each matcher
};

// Reads the folder and its recording `pmd`, fuses and scores. One line when a file is missing or
// says nothing of a floor, or when the options mean nothing.
dataset::Loaded<FloorCase> run_floor_case(const std::filesystem::path& folder,
                                          std::span<const MatchRequest> matchers,
                                          const FusionOptions& options);

// (depth - truth) / truth of each pixel; +inf where one of them is unknown.
dataset::Image<float> relative_error(const dataset::Image<float>& depth,
                                     const dataset::Image<float>& truth);

}  // namespace stof::host
