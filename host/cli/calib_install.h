#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/control_flags.h"
#include "host/cli/upload_way.h"

// `stof calib install`: puts a calibration file on a sensor.
namespace stof::host {

struct CalibInstallOptions : ControlFlags {
  std::vector<std::string> words{};  // FILE SENSOR; no FILE with `factory`, no SENSOR with `serial`
  bool json = false;
  bool factory = false;    // goes back to the factory's calibration
  double patience_s = 40;  // without an answer
};

// The bytes of a calibration file; what no sensor takes is told before anything is sent. Throws
// Failure.
std::string read_calibration_bytes(const std::filesystem::path& file);

struct Installed {
  std::uint32_t fingerprint = 0;  // of the calibration that is in force
  std::uint32_t former = 0;
};
// Puts these bytes in force and has them kept; none: goes back to the factory's. sent: told how
// many bytes the sensor has, of how many. Throws Failure.
Installed put_calibration(UploadWay& way, const std::string& bytes,
                          const std::function<void(std::size_t, std::size_t)>& sent);

// Adds the command to `stof calib`; it runs when the command line was parsed.
void add_calib_install(CLI::App& calib, CalibInstallOptions& options);

// Prints to stdout, and progress to stderr where that is a terminal. Throws Failure.
void calib_install(const CalibInstallOptions& options);

}  // namespace stof::host
