#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

namespace stof::host {

struct RecoverOptions {
  std::filesystem::path file;
  std::filesystem::path out;  // empty: in place
  bool force = false;         // replaces OUT where it is there
  bool json = false;
};

// Adds `stof recover` and its flags; it runs when the command line was parsed.
void add_recover(CLI::App& app, RecoverOptions& options);

// `stof recover`: gives a cut recording its index again. Throws Failure.
void recover(const RecoverOptions& options);

}  // namespace stof::host
