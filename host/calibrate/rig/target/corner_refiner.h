#pragma once

#include <cstdint>
#include <vector>

#include "dataset/image.h"
#include "dsp/calib/pinhole.h"
#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/corner_finder.h"

namespace stof::host {

struct RefineOptions {
  // Which corners are fitted, the others only tell how the board lies; empty: all.
  std::vector<bool> asked{};
  // Of the camera, where it is known: edges are bent as it bends them. Else they are straight for
  // 10 px to both sides.
  const dsp::Pinhole* lens = nullptr;
};

// Where the printed edges of each corner cross, by least squares of grey values: the four squares
// that meet there, in light whose logarithm is a quadratic of the place, their edges smoothed
// by the same Gaussian and by the pixels' square, as far as the print shows nothing else. corners:
// in the order of Board, within a pixel or two of the truth; kUnseen stays kUnseen, and a corner
// stays as it is where the values do not show one: no contrast, half outside of the picture, less
// than two pixels to the next edge. Returns of each whether it was fitted. What is fitted has its
// covariance, from the slopes of the grey values and what the model left of them (for corners:
// Foerstner and Guelch 1987; weights are not those of the errors, hence the form of White 1980).
// Dim, blurred and small corners are worth less.
std::vector<bool> refine_corners(const dataset::Image<float>& picture, const Board& board,
                                 std::vector<PixelPoint>& corners,
                                 const RefineOptions& options = {});

std::vector<bool> refine_corners(const dataset::Image<std::uint8_t>& picture, const Board& board,
                                 std::vector<PixelPoint>& corners,
                                 const RefineOptions& options = {});

}  // namespace stof::host
