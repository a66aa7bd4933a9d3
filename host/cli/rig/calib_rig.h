#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/cli/receive.h"

// `stof calib stereo`, `extrinsics`, `check`, `import`, `export` and `target`: a component of its
// own, which needs the packages of `scripts/setup calib`. Built without, the commands say so.
namespace stof::host {

inline constexpr double kMmPerMetre = 1000;

// Of the forms with --live: `sensor` is the one that shows what a folder would hold.
struct CalibLiveOptions : ReceiveOptions {
  std::filesystem::path
      keep{};  // folder that views are kept in; empty: beside the file that is made
  double time_limit_s = 900;
  std::uint16_t every = 4;      // one exposure of so many frames is looked at
  std::size_t views = 20;       // that are wanted at least
  double most_motion_px = 1;    // between exposures, of what holds still
  std::size_t pmd_frames = 16;  // of the PMD camera for each view
  bool on() const { return !sensor.empty(); }
};

struct CalibStereoOptions {
  CalibLiveOptions live{};
  std::filesystem::path target{};  // folder; this or planes
  std::filesystem::path planes{};
  std::filesystem::path out{};
  std::filesystem::path start{};  // empty: none
  std::filesystem::path page{};   // empty: none
  std::string board = "9x6:0.024";
  int hold_out = -1;  // every so many; -1: the command's own
  double most_blur_px = 1.5;
  bool force = false;
  // Of --planes.
  std::vector<double> distances{};           // with --live: of the walls that are shown, m
  std::vector<double> baseline{0.2, 0.002};  // m and its sigma
  std::vector<double> focal{8.5, 0.17};      // mm and its sigma
  double pixel_um = 5.6;
  std::vector<double> centre{};  // cx left, cx right, cy; empty: the middle
  int min_disparity = -64;
  int disparities = 256;
  int block = 17;
  unsigned seed = 1;
  bool chapter = false;
  int threads = 1;
  bool json = false;
  int picture_width = 0;  // of the pictures in --live --json, px; 0: none
};

struct CalibFolderOptions {  // extrinsics, check
  CalibLiveOptions live{};
  std::filesystem::path folder{};
  std::filesystem::path calibration{};
  std::filesystem::path out{};
  int min_disparity = 0;
  int disparities = 128;
  double offset_mm = 3;
  std::string board{};  // of extrinsics: views of it in place of walls
  int threads = 1;
  bool force = false;
  bool json = false;
};

struct CalibExchangeOptions {  // import, export
  std::string format{};
  std::vector<std::filesystem::path> files{};
  std::filesystem::path out{};
  std::filesystem::path start{};
  std::vector<int> size{};
  bool json = false;
};

struct CalibTargetOptions {
  std::string board = "9x6:0.024";
  std::string paper = "a4";
  std::filesystem::path out{};
  bool json = false;
};

struct CalibRigOptions {
  CalibStereoOptions stereo;
  CalibFolderOptions extrinsics;
  CalibFolderOptions check;
  CalibExchangeOptions import;
  CalibExchangeOptions export_to;
  CalibTargetOptions target;
};

// False: the commands say what this build lacks, as kRigAbsence.
bool has_calib_rig() noexcept;
// One line: what to do for a `stof` that has the commands.
inline constexpr const char* kRigAbsence =
    "this stof was built without it: run scripts/setup calib, build preset calib, and use that "
    "stof";

// How each of the commands is called, whether this build has it or not.
std::string calib_rig_example(std::string_view command);

// Adds the commands to `stof calib`; one of them runs when the command line was parsed.
void add_calib_rig(CLI::App& calib, CalibRigOptions& options);

// Print to stdout, write the files. Throw Failure.
void calib_stereo(const CalibStereoOptions& options);
void calib_extrinsics(const CalibFolderOptions& options);
void calib_check(const CalibFolderOptions& options);
void calib_import(const CalibExchangeOptions& options);
void calib_export(const CalibExchangeOptions& options);
void calib_target(const CalibTargetOptions& options);

}  // namespace stof::host
