#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/control_flags.h"

// `stof update`: puts another release on a sensor.
namespace stof::host {

struct UpdateOptions : ControlFlags {
  std::vector<std::string> words{};  // SENSOR FILE; no FILE with `revert`, no SENSOR with `serial`
  bool json = false;
  bool revert = false;     // tries the release in the other slot
  bool no_wait = false;    // ends when the sensor restarts
  double wait_s = 240;     // for the restart and what comes of it
  double patience_s = 40;  // without an answer meanwhile
};

void add_update(CLI::App& app, UpdateOptions& options);

// Prints to stdout, and progress to stderr where that is a terminal. Throws Failure.
void update(const UpdateOptions& options);

}  // namespace stof::host
