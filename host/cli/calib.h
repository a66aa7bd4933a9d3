#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/calib_install.h"
#include "host/cli/calib_live_pmd.h"
#include "host/cli/rig/calib_rig.h"

// `stof calib pmd`: the constants of a PMD sensor from recordings of a wall at known distances.
namespace stof::host {

struct CalibPmdOptions {
  PmdLiveOptions live{};
  std::filesystem::path folder;
  std::filesystem::path out;
  std::filesystem::path start;  // empty: none
  std::filesystem::path plots;  // empty: no pictures
  std::string frames = "all";
  std::string phase = "auto";
  std::vector<std::string> fit;  // names of constants; empty: all
  std::vector<double> lens;      // fx fy cx cy k1 k2 k3 p1 p2, the last five optional
  std::vector<double> emitters;  // x y z of each light, metres
  bool no_emitters = false;
  double albedo = 0.9;
  bool force = false;  // write the file of a model that does not explain the walls
  bool json = false;
};

// Adds `stof calib` with this command, `install` and those of calib_rig.h; one runs when the
// command line was parsed.
void add_calib(CLI::App& app, CalibPmdOptions& options, CalibInstallOptions& install,
               CalibRigOptions& rig);

// Prints to stdout, writes the files. Throws Failure, behind the report where the model does not
// explain the walls.
void calib_pmd(const CalibPmdOptions& options);

}  // namespace stof::host
