#pragma once

#include <string>
#include <vector>

#include "host/evaluate/ifm/frame.h"
#include "host/evaluate/pmd/edges.h"
#include "host/evaluate/pmd/frequencies.h"
#include "host/evaluate/pmd/lights.h"
#include "host/evaluate/pmd/phase.h"
#include "host/evaluate/pmd/walls.h"

// All figures of a folder of PMD recordings, by the appliance's own converter.
namespace stof::host {

struct PmdOptions {
  std::filesystem::path folder;
  std::filesystem::path
      calibration;                // a calibration file; empty: recordings' own, walls are fitted
  Frames fitted = Frames::kEven;  // of walls; the others judge
  long phase_samples = 4'000'000;
};

struct PmdEvaluation {
  std::filesystem::path folder;
  PhaseScore phase;
  std::vector<WallStudy> walls;
  std::vector<LightStudy> lights;
  std::vector<EdgeStudy> edges;
  std::vector<FrequencyStudy> frequencies;
  std::vector<EdgeStudy> scenes;
  std::vector<FrameStudy> frames;
  std::vector<std::string> notes;  // what was skipped, and what is absent
};

// One line for input that is bad.
dataset::Loaded<PmdEvaluation> evaluate_pmd(const PmdOptions& options);

}  // namespace stof::host
