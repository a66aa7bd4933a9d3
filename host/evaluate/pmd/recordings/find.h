#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/evaluate/pmd/recordings/truth.h"

// The PMD recordings of a folder, found by files and json fields.
namespace stof::host {

enum class PmdKind : std::uint8_t {
  kWalls,        // "z_m": a wall at known distances; one camera a folder
  kLights,       // the same, and the lights are to one side of the lens
  kEdge,         // "x_edge_m", and maps r_min, r_max
  kFrequencies,  // "pair": two modulation frequencies; prefixes come in pairs, first frequency
                 // first
  kScenes,       // none of these, and maps r_min, r_med, r_max
  kFrame,        // a frame of an ifm camera: info.json and radial_distance.pgm
};

struct PmdSet {
  PmdKind kind = PmdKind::kWalls;
  std::filesystem::path folder;
  std::vector<std::filesystem::path> prefixes;  // by name; of a frame: none
};

struct PmdFolders {
  std::vector<PmdSet> sets;  // by folder and kind
  PmdSources sources;        // the fixed patterns that were seen
  std::vector<std::string> notes;
};

// `folder` and what lies in it, two levels deep. One line where it cannot be read, holds nothing of
// these kinds, or a json in it cannot be read. Recordings without truth are named in the notes.
dataset::Loaded<PmdFolders> find_pmd(const std::filesystem::path& folder);

}  // namespace stof::host
