#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/evaluate/pmd/recordings/find.h"

// The gain from knowing where the lights stand that are not at the lens.
namespace stof::host {

// One distance of a wall lit from the side.
struct LightRow {
  std::string name;
  double z_m = 0;
  // Mean over pixels (or blocks of 8x8, where noise is an eighth) of |mean radial error|.
  double before_m = 0;  // lights taken to be at the lens
  double after_m = 0;
  double before_blocks_m = 0;
  double after_blocks_m = 0;
  int pixels = 0;  // that carry a distance in half of the frames or more
};

struct LightStudy {
  std::filesystem::path folder;
  std::vector<LightRow> rows;
};

dataset::Loaded<LightStudy> study_lights(const PmdSet& set, const PmdSources& sources);

}  // namespace stof::host
