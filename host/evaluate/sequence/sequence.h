#pragma once

#include <expected>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/evaluate/fusion/owning_depth_maker.h"
#include "host/evaluate/sequence/sequence_score.h"
#include "host/evaluate/stereo/match.h"

namespace stof::host {

// How often the frames are fused, each time from the beginning.
struct SequenceRun {
  MatchRequest matcher;
  DepthMakerOptions options;
};

struct SequenceResult {
  SequenceScore score;
  double fuse_ms = 0;  // median of the frames, filter included
};

// The folders of recorded pairs in `folder`, by name, each with its PMD recording `pmd` where the
// PMD camera exposed: one result for each run. One line when there are none, when a file is missing
// or without truth, or when options mean nothing.
dataset::Loaded<std::vector<SequenceResult>> run_sequence(const std::filesystem::path& folder,
                                                          std::span<const SequenceRun> runs,
                                                          int warm_up);

}  // namespace stof::host
