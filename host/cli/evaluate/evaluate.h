#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

#include "host/evaluate/stereo/match.h"

// The common part of `stof evaluate stereo`, `fusion`, `floor` and
// `sequence`.
namespace stof::host {

struct EvaluateOptions {
  MatchRequest match;
  bool json = false;
  std::filesystem::path out;  // empty: nothing is written
};

// What a command judges. Depth is of what enters the fusion: disparities that are filled, or of an
// offline search, do not.
enum class Judged : std::uint8_t { kDisparity, kDepth };

// Adds the flags that these commands share.
void add_evaluate_flags(CLI::App& command, EvaluateOptions& options, Judged judged);
// Adds --out, to a command that leaves maps.
void add_out_flag(CLI::App& command, EvaluateOptions& options);
// Adds --runs.
void add_runs_flag(CLI::App& command, EvaluateOptions& options);
// Makes the folder where it is missing. Throws Failure.
void make_folder(const std::filesystem::path& folder);

// "12.3", or "-" for what could not be counted: a share in percent, right-aligned in `columns`.
std::string percent_text(std::optional<double> share, int columns);
// A value in so many of a unit; null for what could not be counted.
nlohmann::ordered_json json_number(std::optional<double> value, double unit = 1);

}  // namespace stof::host
