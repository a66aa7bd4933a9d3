#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

// `stof calib install`: puts a calibration file on a sensor.
namespace stof::host {

struct CalibInstallOptions {
  std::vector<std::string> words{};  // FILE SENSOR; no FILE with `factory`, no SENSOR with `serial`
  bool factory = false;              // goes back to the factory's calibration
  std::string serial{};              // device; empty: over the network
  unsigned baud = 921'600;
  std::optional<std::uint32_t> device{};  // number of the sensor; none: who is known there
  std::string key{};       // id of the key that alone counts; empty: of those there are
  std::string keys{};      // this user's; empty: the usual one
  double timeout_s = 0.3;  // of each of three attempts
  double patience_s = 20;  // without an answer
};

// Adds the command to `stof calib`; it runs when the command line was parsed.
void add_calib_install(CLI::App& calib, CalibInstallOptions& options);

// Prints to stdout, and progress to stderr where that is a terminal. Throws Failure.
void calib_install(const CalibInstallOptions& options);

}  // namespace stof::host
