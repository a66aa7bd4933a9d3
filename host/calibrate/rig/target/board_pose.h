#pragma once

#include <optional>
#include <vector>

#include "dsp/calib/pinhole.h"
#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/corner_finder.h"
#include "host/calibrate/rig/target/lens_model.h"

// Poses and lenses for fits to begin with, by OpenCV.
namespace stof::host {

// From the board's axes to the camera's. None where OpenCV finds none.
std::optional<PoseUnknowns> pose_of_board(const Board& board,
                                          const std::vector<PixelPoint>& corners,
                                          const dsp::Pinhole& lens);

// A lens of this size with k1 and k2, from views of the board (corners that are not seen do not
// count). None where there are fewer than three, or what comes out is no lens.
std::optional<dsp::Pinhole> lens_of_views(const Board& board,
                                          const std::vector<std::vector<PixelPoint>>& views,
                                          int width, int height);

}  // namespace stof::host
