#pragma once

#include <cstdint>
#include <string>

#include <CLI/CLI.hpp>

namespace stof::host {

struct PairOptions {
  std::string into{};  // key file of a sensor that does not run
  std::uint32_t device = 1;
  std::string role = "admin";
  std::string name{};  // whose key it is; empty: USER@HOST
  std::string keys{};  // this user's; empty: the usual one
};

// Adds `stof pair` and its flags; it runs when the command line was parsed.
void add_pair(CLI::App& app, PairOptions& options);

// `stof pair`: makes a key that a sensor and this user share. Throws Failure.
void pair(const PairOptions& options);

// The user's key file where a flag names none.
std::string keys_file(const std::string& named);

}  // namespace stof::host
