#pragma once

#include <array>
#include <vector>

#include "host/calibrate/rig/target/pair_fit.h"

namespace stof::host {

// Where in the pictures corners were found: how many in each cell of a grid over the picture, row
// by row from the upper left.
struct CornerCells {
  static constexpr int kColumns = 8;
  static constexpr int kRows = 6;
  using Eye = std::array<int, std::size_t{kColumns} * kRows>;
  Eye left{};
  Eye right{};
};

// width, height: of the cameras' pictures, px. A corner on the edge counts for the cell inside.
CornerCells corner_cells(const std::vector<PairView>& views, int width, int height);

}  // namespace stof::host
