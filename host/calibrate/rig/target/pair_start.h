#pragma once

#include <vector>

#include "dataset/image.h"
#include "host/calibrate/rig/target/pair_fit.h"

namespace stof::host {

// A start for fit_pair() by OpenCV, from the views alone.
struct PairStart {
  dsp::RawPair rig;
  std::vector<PoseUnknowns> boards;
};

// One line where a lens or a pose cannot be had from these views.
dataset::Loaded<PairStart> start_of(const Board& board, const std::vector<PairView>& views,
                                    int width, int height);

}  // namespace stof::host
