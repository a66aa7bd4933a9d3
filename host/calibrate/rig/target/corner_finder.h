#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "dataset/image.h"
#include "dsp/calib/pinhole.h"
#include "host/calibrate/rig/target/board.h"

namespace stof::host {

struct PixelPoint {
  double u = 0;
  double v = 0;
  // Covariance of the place, px^2. Fits take only what corners are worth against each other: how
  // far they really scatter is told by the residuals.
  double uu = 1;
  double uv = 0;
  double vv = 1;
  bool seen() const { return std::isfinite(u); }
};
// In the place of a corner that is not seen, of a board that is seen in part.
inline constexpr PixelPoint kUnseen{std::numeric_limits<double>::quiet_NaN(),
                                    std::numeric_limits<double>::quiet_NaN()};
inline constexpr int kFewestSeen = 12;  // of a board that is seen in part

// How many of them are seen.
std::size_t seen_corners(const std::vector<PixelPoint>& corners);

// A board in a picture: all of its corners, in the order of Board.
struct FoundBoard {
  std::vector<PixelPoint> corners;
  // How wide the edges between black and white are, px: the standard deviation of the Gaussian that
  // a step was smoothed with. The worse of the board's two directions, because motion blurs one.
  double blur_px = 0;
};

inline constexpr double kRoughPx = 0.1;  // standard deviation of a corner that is not refined

// Finds the board by OpenCV, and where its corners are by corner_refiner.h. A chessboard is found
// where it is seen whole, a board with markers in part (marker_finder.h); else none. blur_px tells
// how much the corners of a smeared picture are worth.
std::optional<FoundBoard> find_board(const dataset::Image<std::uint8_t>& picture,
                                     const Board& board);
// The same through a lens that is known, which bends edges: corners in the margins of a picture are
// more exact.
std::optional<FoundBoard> find_board_through(const dsp::Pinhole& lens,
                                             const dataset::Image<std::uint8_t>& picture,
                                             const Board& board);
// The same in a fifth of the time, to a tenth of a pixel, without blur_px (NaN): for pictures of
// which most are left out.
std::optional<FoundBoard> find_board_roughly(const dataset::Image<std::uint8_t>& picture,
                                             const Board& board);

// FoundBoard::blur_px; NaN where no edge has any contrast.
double edge_blur(const dataset::Image<std::uint8_t>& picture, const Board& board,
                 const std::vector<PixelPoint>& corners);

}  // namespace stof::host
