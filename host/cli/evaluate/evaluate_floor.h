#pragma once

#include <filesystem>
#include <vector>

#include "host/cli/evaluate/evaluate.h"

// `stof evaluate floor`: what a robot would make of depth maps of scenes above a floor.
namespace stof::host {

struct EvaluateFloorOptions : EvaluateOptions {
  std::vector<std::filesystem::path> folders;
};

// Adds the command and its flags; it runs when the command line was parsed.
void add_evaluate_floor(CLI::App& evaluate, EvaluateFloorOptions& options);

// Prints to stdout. Throws Failure.
void evaluate_floor(const EvaluateFloorOptions& options);

}  // namespace stof::host
