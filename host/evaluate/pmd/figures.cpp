#include "host/evaluate/pmd/figures.h"

#include <algorithm>

#include "host/calibrate/calibration_store.h"

namespace stof::host {
namespace {

constexpr std::size_t kFewestWalls = 3;
using Done = std::expected<void, dataset::Problem>;

template <typename Study>
Done keep(dataset::Loaded<Study> study, std::vector<Study>& studies) {
  if (!study) {
    return std::unexpected(std::move(study.error()));
  }
  studies.push_back(std::move(*study));
  return {};
}

Done add_set(const PmdSet& set, const PmdSources& sources, Frames fitted, PmdEvaluation& out) {
  switch (set.kind) {
    case PmdKind::kWalls:
      if (set.prefixes.size() < kFewestWalls) {
        out.notes.push_back(set.folder.string() +
                            ": fewer than three distances of a wall; not calibrated");
        return {};
      }
      return keep(study_walls(set, sources, fitted), out.walls);
    case PmdKind::kLights:
      return keep(study_lights(set, sources), out.lights);
    case PmdKind::kEdge:
      return keep(study_edges(set, sources), out.edges);
    case PmdKind::kFrequencies:
      return keep(study_frequencies(set, sources), out.frequencies);
    case PmdKind::kScenes:
      return keep(study_edges(set, sources), out.scenes);
    case PmdKind::kFrame:
      return keep(study_frame(set.folder), out.frames);
  }
  return {};
}

// The recordings that a calibration is given for, and cannot be used with.
Done note_other_cameras(const PmdFolders& folders, std::vector<std::string>& notes) {
  const std::optional<dsp::PmdSensor>& known = folders.sources.calibration;
  for (const PmdSet& set : folders.sets) {
    std::size_t others = 0;
    for (const std::filesystem::path& prefix : set.prefixes) {
      const dataset::Loaded<PmdSetup> setup = read_setup(prefix);
      if (!setup) {
        return std::unexpected(setup.error());
      }
      others += known && !setup->is_of(*known) ? 1U : 0U;
    }
    if (others > 0) {
      notes.push_back(set.folder.string() + ": the calibration is not used with " +
                      std::to_string(others) +
                      " of its recordings: another size or modulation frequency");
    }
  }
  return {};
}

void note_absent(const std::vector<PmdSet>& sets, std::vector<std::string>& notes) {
  struct Kind {
    PmdKind kind;
    const char* absent;
  };
  for (const Kind& each :
       {Kind{PmdKind::kWalls, "walls at known distances (\"z_m\")"},
        Kind{PmdKind::kLights, "a wall lit from one side (\"emitters\" beside the lens)"},
        Kind{PmdKind::kEdge, "an edge (\"x_edge_m\", r_min, r_max)"},
        Kind{PmdKind::kFrequencies, "two modulation frequencies (\"pair\")"},
        Kind{PmdKind::kScenes, "scenes with range maps (r_min, r_med, r_max)"},
        Kind{PmdKind::kFrame, "a frame of an ifm camera (info.json, radial_distance.pgm)"}}) {
    if (std::ranges::find(sets, each.kind, &PmdSet::kind) == sets.end()) {
      notes.push_back(std::string("absent: ") + each.absent);
    }
  }
}

}  // namespace

dataset::Loaded<PmdEvaluation> evaluate_pmd(const PmdOptions& options) {
  dataset::Loaded<PmdFolders> folders = find_pmd(options.folder);
  if (!folders) {
    return std::unexpected(std::move(folders.error()));
  }
  StoredCalibration stored;
  if (!options.calibration.empty()) {
    dataset::Loaded<StoredCalibration> read = read_pmd_calibration(options.calibration);
    if (!read) {
      return std::unexpected(std::move(read.error()));
    }
    stored = std::move(*read);
    folders->sources.calibration = stored.calibration.pmd;
  }
  PmdEvaluation out;
  out.folder = options.folder;
  out.notes = std::move(folders->notes);
  if (Done noted = note_other_cameras(*folders, out.notes); !noted) {
    return std::unexpected(std::move(noted.error()));
  }
  out.phase = score_phase(options.phase_samples);
  for (const PmdSet& set : folders->sets) {
    if (Done done = add_set(set, folders->sources, options.fitted, out); !done) {
      return std::unexpected(std::move(done.error()));
    }
  }
  note_absent(folders->sets, out.notes);
  // What the studies' sensors borrow ends here.
  for (WallStudy& wall : out.walls) {
    if (wall.given) {
      wall.calibration.sensor.fixed_pattern = {};
    }
  }
  return out;
}

}  // namespace stof::host
