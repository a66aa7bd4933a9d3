#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/calibrate/rig/extrinsics/extrinsic_fit.h"

// Exposures of both sensors: a pair of pictures and a PMD recording beside them.
namespace stof::host {

// How a pair is matched here: preset `quality`, fitted to 1/16 px.
struct WallPairOptions {
  int min_disparity = 0;
  int disparities = 128;
  int threads = 1;
};

// What both sensors made of one exposure.
struct BothLooks {
  std::string name;
  std::vector<PlaneLook> stereo;  // axes of the rectified left camera; one of each 12 by 12 px
  std::vector<PlaneLook> pmd;     // axes of the PMD camera; the mean of each pixel's long exposures
};

// Folders in DIR with left.pgm, right.pgm, pmd.json, pmd_raw.pgm, through the appliance's matcher
// and converter with the constants of `calibration` (complete(), with a PMD camera). One line where
// there is none, or one is of another size than the calibration's cameras.
dataset::Loaded<std::vector<BothLooks>> read_looks(const std::filesystem::path& dir,
                                                   const dsp::Calibration& calibration,
                                                   const WallPairOptions& options);

struct FoundWalls {
  std::vector<SeenWall> walls;
  std::vector<std::string> refused;  // "NAME: the pair sees no wall ..."
};
FoundWalls walls_of(const std::vector<BothLooks>& looks);

}  // namespace stof::host
