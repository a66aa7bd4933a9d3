#pragma once

#include "host/calibrate/walls/pmd_wall.h"

// A folder of recordings, as far as a calibration needs it.
namespace stof::host {

struct WallFolder {
  std::vector<std::filesystem::path> prefixes;
  std::vector<double> exposures;  // of each, relative to the longest integration time
  std::vector<Wall> walls;        // of the chosen frames
  // The camera as the recordings know it; stereo and pmd_to_stereo where one has a rig.
  dsp::Calibration calibration;
  bool has_rig = false;
};

// Keeps what summarise() says of each recording, so that only one is in memory at a time. One line
// where the folder has no recording of a wall, or recordings of different cameras.
dataset::Loaded<WallFolder> read_folder(const std::filesystem::path& folder, Frames frames);

// Recording number n again.
dataset::Loaded<WallRecording> read_again(const WallFolder& folder, std::size_t n);

}  // namespace stof::host
