#pragma once

#include <filesystem>
#include <vector>

#include "host/cli/evaluate/evaluate.h"

// `stof evaluate stereo`: scores of recorded pairs against their truth.
namespace stof::host {

struct EvaluateStereoOptions : EvaluateOptions {
  std::vector<std::filesystem::path> scenes;
};

// Prints to stdout. Throws Failure.
void evaluate_stereo(const EvaluateStereoOptions& options);

}  // namespace stof::host
