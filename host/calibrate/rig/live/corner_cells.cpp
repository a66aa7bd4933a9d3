#include "host/calibrate/rig/live/corner_cells.h"

#include <algorithm>

namespace stof::host {
namespace {

void count_cells(const std::vector<PixelPoint>& corners, int width, int height,
                 CornerCells::Eye& cells) {
  // Corners are told from the centre of the first pixel.
  const auto cell = [](double at, int size, int count) {
    return std::clamp(static_cast<int>((at + 0.5) / size * count), 0, count - 1);
  };
  for (const PixelPoint& corner : corners) {
    if (corner.seen()) {
      const int row = cell(corner.v, height, CornerCells::kRows);
      const int column = cell(corner.u, width, CornerCells::kColumns);
      ++cells[static_cast<std::size_t>(row * CornerCells::kColumns + column)];
    }
  }
}

}  // namespace

CornerCells corner_cells(const std::vector<PairView>& views, int width, int height) {
  CornerCells cells;
  for (const PairView& view : views) {
    count_cells(view.left, width, height, cells.left);
    count_cells(view.right, width, height, cells.right);
  }
  return cells;
}

}  // namespace stof::host
