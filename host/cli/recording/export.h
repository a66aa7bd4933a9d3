#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "host/cli/receive.h"

namespace stof::host {

struct ExportOptions : ReceiveOptions {  // sensor: also a file
  std::filesystem::path to;
  std::string as;            // png16, ply, pcd, csv or tum
  std::uint64_t frames = 0;  // the first ones; 0: all
  bool json = false;
};

// Adds `stof export` and its flags; it runs when the command line was parsed.
void add_export(CLI::App& app, ExportOptions& options);
}  // namespace stof::host
