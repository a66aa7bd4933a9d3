#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/image.h"

namespace stof::host {

// A calibration board: what it is printed as, and what is looked for in pictures. Its corners lie
// in a grid and are counted row by row. The board's axes: x along a row, y from row to row, z into
// the board (away from a camera that looks at it), origin at the first corner.
//   chessboard  corners are those where four squares meet. The square right and below of the first
//               corner is black, as is that left and above of it
//   ChArUco     the same, with an ArUco marker in the middle of each white square: numbers from 0
//               on, row by row, as OpenCV 4.6 and later lay it out
//   AprilGrid   Kalibr's: tags 36h11 with borders two cells wide, number 0 lower left; the four
//               corners of each tag count. Small black squares touch all of them
// Markers tell corners apart, so that a board with them need not be seen whole.
struct Board {
  enum class Kind : std::uint8_t { kChess, kCharuco, kAprilGrid };

  int columns = 0;      // of corners; two a tag
  int rows = 0;         // of corners
  double square_m = 0;  // side of a square, or of a tag, as measured on the print
  Kind kind = Kind::kChess;
  double share = 0;  // of square_m: a ChArUco marker's side, or the gap between tags
  int bits = 0;      // a side, of a ChArUco marker: 4, 5 or 6

  int corners() const { return columns * rows; }
  bool has_markers() const { return kind != Kind::kChess; }
  std::array<double, 2> at(int corner) const {
    const int row = corner / columns;
    return {along(corner - row * columns), along(row)};
  }

 private:
  double along(int number) const {
    if (kind != Kind::kAprilGrid) {
      return square_m * number;
    }
    const int tag = number / 2;
    return square_m * (tag * (1 + share) + (number - 2 * tag));
  }
};

// One line where it is none of these: 3 to 50 corners or 2 to 20 tags a side, squares of 1 mm to
// 1 m.
//   9x6:0.030                    a chessboard of 9 by 6 corners (10 by 7 squares) of 30 mm; one
//                                side odd and the other even (else nobody sees which way round it
//                                is)
//   charuco:9x6:0.030            the same with markers of 3/4 of a square, of 4x4 bits
//   charuco:9x6:0.030:0.022:5x5  markers of 22 mm, of 5x5 bits (or 6x6)
//   aprilgrid:6x6:0.088:0.3      6 by 6 tags of 88 mm, 0.3 of that between them
dataset::Loaded<Board> board_named(std::string_view text);
std::string to_string(const Board& board);

// Where the board's markers are and what they look like.
struct BoardMarker {
  int id = 0;
  double x_m = 0;  // of its upper left corner, in the board's axes
  double y_m = 0;
  int column = 0;  // of the square or tag, from the upper left one on
  int row = 0;
};
std::vector<BoardMarker> markers_of(const Board& board);
double marker_side_m(const Board& board);

}  // namespace stof::host
