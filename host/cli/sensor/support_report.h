#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

#include "host/cli/sensor/check.h"

namespace stof::host {

struct SupportReportOptions : CheckOptions {
  std::filesystem::path file;
  bool force = false;
  bool no_pictures = false;
};

// Adds `stof report`: one file that says all that somebody who helps would ask for.
void add_support_report(CLI::App& app, SupportReportOptions& options, const char* version);

}  // namespace stof::host
