#include "host/calibrate/walls/wall_folder.h"

#include <algorithm>
#include <optional>

#include "dataset/files/file.h"

namespace stof::host {
namespace {

// Where the files tell microseconds and nothing else, these are relative to the longest.
void make_relative(const std::vector<double>& integration_us, WallFolder& folder) {
  const double longest = std::ranges::max(integration_us);
  const bool told = std::ranges::all_of(integration_us, [](double us) { return us > 0; }) &&
                    std::ranges::all_of(folder.exposures, [](double e) { return e == 1; });
  for (std::size_t n = 0; n < folder.walls.size() && told; ++n) {
    folder.exposures[n] = integration_us[n] / longest;
    folder.walls[n].exposure = folder.exposures[n];
  }
  folder.calibration.pmd.integration_us = told ? longest : 0;
}

}  // namespace

dataset::Loaded<WallFolder> read_folder(const std::filesystem::path& folder, Frames frames) {
  dataset::Loaded<std::vector<std::filesystem::path>> prefixes = list_walls(folder);
  if (!prefixes) {
    return std::unexpected(std::move(prefixes.error()));
  }
  WallFolder found;
  std::optional<WallRecording> first;
  std::vector<double> integration_us;
  for (const std::filesystem::path& prefix : *prefixes) {
    dataset::Loaded<WallRecording> wall = read_wall(prefix);
    if (!wall) {
      return std::unexpected(std::move(wall.error()));
    }
    const dataset::PmdRecording& recording = wall->recording;
    if (first) {
      if (const std::string why = mixed(*first, *wall); !why.empty()) {
        return dataset::refuse(prefix, "not of the camera of " + first->name + " (" + why + ")",
                               "give recordings of one camera");
      }
    }
    if (recording.has_rig && !found.has_rig) {
      found.calibration = recording.calibration;
      found.has_rig = true;
    }
    Wall summary = summarise(*wall, frames);
    if (summary.frames == 0) {
      continue;
    }
    integration_us.push_back(recording.calibration.pmd.integration_us);
    found.prefixes.push_back(prefix);
    found.exposures.push_back(wall->exposure);
    found.walls.push_back(std::move(summary));
    if (!first) {
      first = std::move(*wall);
    }
    first->recording.frames.resize(1);
  }
  if (!first) {
    return dataset::refuse(folder, "holds no recording of a wall whose json says \"z_m\"",
                           "give a folder of such recordings");
  }
  found.calibration.pmd = first->recording.calibration.pmd;
  make_relative(integration_us, found);
  return found;
}

dataset::Loaded<WallRecording> read_again(const WallFolder& folder, std::size_t n) {
  dataset::Loaded<WallRecording> wall = read_wall(folder.prefixes[n]);
  if (wall) {
    wall->exposure = folder.exposures[n];
  }
  return wall;
}

}  // namespace stof::host
