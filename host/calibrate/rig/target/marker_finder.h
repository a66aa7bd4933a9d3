#pragma once

#include <optional>
#include <vector>

#include "host/calibrate/rig/target/corner_finder.h"

// Boards with markers, by OpenCV's module aruco: it tells which corner is which, corner_refiner.h
// where it is.
namespace stof::host {

// Whether each cell of a marker is black: its border, then its bits, row by row. Cells a side:
// bits + 2 of ChArUco (a border of one), 10 of an AprilGrid (two).
struct MarkerCells {
  int side = 0;
  std::vector<bool> black;
};
MarkerCells cells_of(const Board& board, int id);

// As find_board_roughly(), of a board with markers: those of its corners that are seen. None where
// they are fewer than kFewestSeen, or lie in one row or column.
std::optional<FoundBoard> find_marked_board(const dataset::Image<std::uint8_t>& picture,
                                            const Board& board);

}  // namespace stof::host
