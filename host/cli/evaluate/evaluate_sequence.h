#pragma once

#include <filesystem>
#include <vector>

#include "host/cli/evaluate/evaluate.h"

// `stof evaluate sequence`: how steady depth is from frame to frame, and whether it follows what
// moves.
namespace stof::host {

struct EvaluateSequenceOptions : EvaluateOptions {
  std::vector<std::filesystem::path> folders;
  int warm_up = 12;
  double max_range_m = 10;
};

// Adds the command and its flags; it runs when the command line was parsed.
void add_evaluate_sequence(CLI::App& evaluate, EvaluateSequenceOptions& options);

// Prints to stdout. Throws Failure.
void evaluate_sequence(const EvaluateSequenceOptions& options);

}  // namespace stof::host
