#include "host/calibrate/rig/target/corner_filler.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>

#include "dsp/base/index.h"
#include "host/calibrate/rig/target/corner_refiner.h"

namespace stof::host {
namespace {

using dsp::index;

constexpr double kMostOff = 1;    // px, of where it is expected
constexpr double kInside = 4;     // px, of the picture
constexpr int kFewestBeside = 2;  // of its eight neighbours

// Where one perspective puts every corner of the board; empty: there is none.
std::vector<cv::Point2f> by_perspective(const Board& board,
                                        const std::vector<PixelPoint>& corners) {
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> in_picture;
  std::vector<cv::Point2f> all;
  for (int i = 0; i < board.corners(); ++i) {
    const std::array<double, 2> at = board.at(i);
    all.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]));
    const PixelPoint& corner = corners[index(i)];
    if (corner.seen()) {
      on_board.push_back(all.back());
      in_picture.emplace_back(static_cast<float>(corner.u), static_cast<float>(corner.v));
    }
  }
  if (on_board.size() < std::size_t{kFewestSeen}) {
    return {};
  }
  const cv::Mat matrix = cv::findHomography(on_board, in_picture);
  if (matrix.empty()) {
    return {};
  }
  cv::perspectiveTransform(all, all, matrix);
  return all;
}

// There, less what its neighbours are off it, because the lens bends; kUnseen where those are few.
PixelPoint expected(const Board& board, const std::vector<PixelPoint>& corners,
                    const std::vector<cv::Point2f>& straight, int corner) {
  const int column = corner % board.columns;
  const int row = corner / board.columns;
  PixelPoint off;
  int beside = 0;
  for (int y = std::max(0, row - 1); y <= std::min(board.rows - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(board.columns - 1, column + 1); ++x) {
      const std::size_t other = index(y * board.columns + x);
      if (corners[other].seen()) {
        off.u += corners[other].u - static_cast<double>(straight[other].x);
        off.v += corners[other].v - static_cast<double>(straight[other].y);
        ++beside;
      }
    }
  }
  if (beside < kFewestBeside) {
    return kUnseen;
  }
  const cv::Point2f& at = straight[index(corner)];
  return {.u = static_cast<double>(at.x) + off.u / beside,
          .v = static_cast<double>(at.y) + off.v / beside};
}

}  // namespace

void fill_corners(const dataset::Image<std::uint8_t>& picture, const Board& board,
                  std::vector<PixelPoint>& corners) {
  // Each corner that is found tells better where those beside it are.
  for (bool more = true; more;) {
    more = false;
    const std::vector<cv::Point2f> straight = by_perspective(board, corners);
    std::vector<PixelPoint> asked = corners;
    for (std::size_t i = 0; i < corners.size() && !straight.empty(); ++i) {
      const PixelPoint at =
          corners[i].seen() ? kUnseen : expected(board, corners, straight, static_cast<int>(i));
      const bool inside = at.u > kInside && at.v > kInside && at.u < picture.width - 1 - kInside &&
                          at.v < picture.height - 1 - kInside;
      if (inside) {
        asked[i] = at;
        more = true;
      }
    }
    if (!more) {
      return;
    }
    const std::vector<PixelPoint> given = asked;
    const std::vector<bool> fitted = refine_corners(picture, board, asked);
    more = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double off = std::hypot(asked[i].u - given[i].u, asked[i].v - given[i].v);
      if (!corners[i].seen() && fitted[i] && off < kMostOff) {
        corners[i] = asked[i];
        more = true;
      }
    }
  }
}

}  // namespace stof::host
