#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "host/cli/evaluate/evaluate.h"

// `stof evaluate fusion`: scores of recorded pairs with their PMD recording against the truth.
namespace stof::host {

struct EvaluateFusionOptions : EvaluateOptions {
  std::vector<std::filesystem::path> pairs;  // STEREO_DIR and PREFIX in turn
  std::optional<double> max_range_m;         // without it the appliance's
  std::vector<float> truth_m;                // near and far end of what is judged; none: all
  bool guided = false;
  bool chapter_geometry = false;
  std::filesystem::path calibration;  // of the PMD cameras; empty: what their jsons say
  std::filesystem::path html;         // empty: no page
};

// All of its flags.
void add_fusion_flags(CLI::App& command, EvaluateFusionOptions& options);

// Prints to stdout. Throws Failure.
void evaluate_fusion(const EvaluateFusionOptions& options);

}  // namespace stof::host
