#pragma once

#include <vector>

#include "dataset/image.h"
#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/corner_finder.h"

namespace stof::host {

// Finds more corners of a board of which some are seen (kFewestSeen or more): one beside those that
// are is where the board's perspective and its neighbours say, and counts where the picture shows
// it there (corner_refiner.h). In far views and in corners of the picture markers are too small to
// be read, corners are not.
void fill_corners(const dataset::Image<std::uint8_t>& picture, const Board& board,
                  std::vector<PixelPoint>& corners);

}  // namespace stof::host
