#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "host/cli/receive.h"
#include "host/recording/recording.h"

namespace stof::host {

struct InfoOptions : ReceiveOptions {  // sensor: also a file
  bool json = false;
};

// Adds `stof info` and its flags; it runs when the command line was parsed.
void add_info(CLI::App& app, InfoOptions& options);

// `stof info`: what a recording holds, or what a sensor is. Throws Failure.
void info(const InfoOptions& options);

std::string info_text(const std::string& file, const recording::Summary& summary);
std::string info_json(const std::string& file, const recording::Summary& summary);

}  // namespace stof::host
