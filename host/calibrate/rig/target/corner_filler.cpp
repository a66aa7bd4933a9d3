#include "host/calibrate/rig/target/corner_filler.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/index.h"
#include "host/calibrate/rig/target/board_perspective.h"
#include "host/calibrate/rig/target/corner_refiner.h"

namespace stof::host {
namespace {

using dsp::index;

constexpr double kMostOff = 1;    // px, of where it is expected
constexpr double kInside = 4;     // px, of the picture
constexpr int kFewestBeside = 2;  // of its eight neighbours

// Where the perspective puts it, less what its neighbours are off that, because the lens bends;
// kUnseen where those are few.
PixelPoint expected(const Board& board, const std::vector<PixelPoint>& corners,
                    const BoardPerspective& straight, int corner) {
  const int column = corner % board.columns;
  const int row = corner / board.columns;
  PixelPoint off;
  int beside = 0;
  for (int y = std::max(0, row - 1); y <= std::min(board.rows - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(board.columns - 1, column + 1); ++x) {
      const int other = y * board.columns + x;
      const PixelPoint& found = corners[index(other)];
      if (found.seen()) {
        const PixelPoint at = straight.at(board.at(other));
        off.u += found.u - at.u;
        off.v += found.v - at.v;
        ++beside;
      }
    }
  }
  if (beside < kFewestBeside) {
    return kUnseen;
  }
  const PixelPoint at = straight.at(board.at(corner));
  return {.u = at.u + off.u / beside, .v = at.v + off.v / beside};
}

}  // namespace

void fill_corners(const dataset::Image<std::uint8_t>& picture, const Board& board,
                  std::vector<PixelPoint>& corners) {
  // Each corner that is found tells better where those beside it are.
  for (bool more = true; more;) {
    more = false;
    const auto straight = BoardPerspective::through(board, corners, kFewestSeen);
    std::vector<PixelPoint> with_expected = corners;
    std::vector<bool> asked(corners.size());
    for (std::size_t i = 0; i < corners.size() && straight; ++i) {
      const PixelPoint at =
          corners[i].seen() ? kUnseen : expected(board, corners, *straight, static_cast<int>(i));
      const bool inside = at.u > kInside && at.v > kInside && at.u < picture.width - 1 - kInside &&
                          at.v < picture.height - 1 - kInside;
      if (inside) {
        with_expected[i] = at;
        asked[i] = more = true;
      }
    }
    if (!more) {
      return;
    }
    const std::vector<PixelPoint> given = with_expected;
    const std::vector<bool> fitted =
        refine_corners(picture, board, with_expected, {.asked = asked});
    more = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double off =
          std::hypot(with_expected[i].u - given[i].u, with_expected[i].v - given[i].v);
      if (fitted[i] && off < kMostOff) {
        corners[i] = with_expected[i];
        more = true;
      }
    }
  }
}

}  // namespace stof::host
