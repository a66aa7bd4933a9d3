#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

// `stof evaluate pmd`: the figures of PMD recordings whose scene is known.
namespace stof::host {

struct EvaluatePmdOptions {
  std::filesystem::path folder;
  std::filesystem::path calibration;  // empty: walls are calibrated, the rest brings its own
  std::filesystem::path html;         // empty: no page
  std::string frames = "even";
  bool json = false;
};

// Adds the command and its flags; it runs when the command line was parsed.
void add_evaluate_pmd(CLI::App& evaluate, EvaluatePmdOptions& options);

// Prints to stdout, writes the page. Throws Failure.
void evaluate_pmd(const EvaluatePmdOptions& options);

}  // namespace stof::host
