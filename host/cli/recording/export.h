#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

namespace stof::host {

struct ExportOptions {
  std::filesystem::path file;
  std::filesystem::path to;
  std::string as;            // png16, ply, pcd, csv or tum
  std::uint64_t frames = 0;  // the first ones; 0: all
  bool json = false;
};

// Adds `stof export` and its flags; it runs when the command line was parsed.
void add_export(CLI::App& app, ExportOptions& options);

// `stof export`: frames of a recording as files of other formats. Throws Failure.
void export_recording(const ExportOptions& options);

}  // namespace stof::host
