#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "host/calibrate/rig/extrinsics/board_extrinsics.h"

namespace stof::host {

struct PmdBoardViews {
  std::vector<PmdBoardView> views;
  std::vector<std::string> refused;  // "NAME: the PMD camera does not see the whole board"
};

// Folders in DIR with left.pgm, right.pgm, pmd.json, pmd_raw.pgm: the board in both pictures and in
// the mean amplitude of the frames. Pictures are as the cameras give them. One line as
// read_looks().
dataset::Loaded<PmdBoardViews> read_board_views(const std::filesystem::path& dir,
                                                const dsp::Calibration& calibration,
                                                const Board& board);

}  // namespace stof::host
