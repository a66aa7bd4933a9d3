#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/image.h"

namespace stof::host {

// A chessboard: what it is printed as, and what is looked for in pictures. Its corners are those
// where four squares meet, counted row by row. The board's axes: x along a row, y from row to row,
// z into the board (away from a camera that looks at it), origin at the first corner. The square
// right and below of the first corner is black.
struct Board {
  int columns = 0;      // of corners
  int rows = 0;         // of corners
  double square_m = 0;  // as measured on the print

  int corners() const { return columns * rows; }
  std::array<double, 2> at(int corner) const {
    const int row = corner / columns;
    return {square_m * (corner - row * columns), square_m * row};
  }
};

// "9x6:0.030": 9 by 6 corners (10 by 7 squares) of 30 mm. One line where it is none: 3 to 50
// corners a side, squares of 1 mm to 1 m, one side odd and the other even (else nobody sees which
// way round the board is).
dataset::Loaded<Board> board_named(std::string_view text);
std::string to_string(const Board& board);

}  // namespace stof::host
