#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/control_flags.h"

// `stof calib install`: puts a calibration file on a sensor.
namespace stof::host {

struct CalibInstallOptions : ControlFlags {
  std::vector<std::string> words{};  // FILE SENSOR; no FILE with `factory`, no SENSOR with `serial`
  bool json = false;
  bool factory = false;    // goes back to the factory's calibration
  double patience_s = 40;  // without an answer
};

// Adds the command to `stof calib`; it runs when the command line was parsed.
void add_calib_install(CLI::App& calib, CalibInstallOptions& options);

// Prints to stdout, and progress to stderr where that is a terminal. Throws Failure.
void calib_install(const CalibInstallOptions& options);

}  // namespace stof::host
