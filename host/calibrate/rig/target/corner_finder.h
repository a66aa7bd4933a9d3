#pragma once

#include <optional>
#include <vector>

#include "dataset/image.h"
#include "host/calibrate/rig/target/board.h"

namespace stof::host {

struct PixelPoint {
  double u = 0;
  double v = 0;
};

// A board in a picture: all of its corners, in the order of Board.
struct FoundBoard {
  std::vector<PixelPoint> corners;
  // How wide the edges between black and white are, px: the standard deviation of the Gaussian that
  // a step was smoothed with. The worse of the board's two directions, because motion blurs one.
  double blur_px = 0;
};

// Finds the board by OpenCV. None where it is not seen whole. Corners of smeared or noisy pictures
// are those that OpenCV gives: blur_px tells how much they are worth.
std::optional<FoundBoard> find_board(const dataset::Image<std::uint8_t>& picture,
                                     const Board& board);

}  // namespace stof::host
