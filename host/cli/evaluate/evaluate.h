#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/evaluate/stereo/match.h"

// `stof evaluate stereo` and `stof evaluate fusion`: scores of recorded scenes against their truth.
namespace stof::host {

struct EvaluateOptions {
  MatchOptions match;
  bool json = false;
  std::filesystem::path out;  // empty: nothing is written
};

struct EvaluateStereoOptions : EvaluateOptions {
  std::vector<std::filesystem::path> scenes;
};

struct EvaluateFusionOptions : EvaluateOptions {
  std::vector<std::filesystem::path> pairs;  // STEREO_DIR and PREFIX in turn
  std::optional<double> max_range_m;         // without it the appliance's
  bool guided = false;
  bool chapter_geometry = false;
  std::filesystem::path html;  // empty: no page
};

// Adds the flags that both commands share.
void add_evaluate_flags(CLI::App& command, EvaluateOptions& options);
// All of `stof evaluate fusion`.
void add_fusion_flags(CLI::App& command, EvaluateFusionOptions& options);

// Print to stdout. Throw Failure.
void evaluate_stereo(const EvaluateStereoOptions& options);
void evaluate_fusion(const EvaluateFusionOptions& options);

// Makes the folder where it is missing. Throws Failure.
void make_folder(const std::filesystem::path& folder);

// "12.3", or "-" for what could not be counted: a share in percent, right-aligned in `columns`.
std::string percent_text(std::optional<double> share, int columns);

}  // namespace stof::host
