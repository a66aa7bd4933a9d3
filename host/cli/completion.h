#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace stof::host {

struct CompletionOptions {
  std::string shell{};
};

// Completion of all commands of `app`, their flags and the values of those that take one of a few:
// a script for bash to source.
std::string bash_completion(const CLI::App& app);

// Adds `stof completion`, which prints it.
void add_completion(CLI::App& app, CompletionOptions& options);

}  // namespace stof::host
