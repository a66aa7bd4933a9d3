#include "host/calibrate/rig/target/board.h"

#include <optional>

#include "dataset/files/file.h"
#include "dsp/base/parse_number.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kFewestCorners = 3;
constexpr int kMostCorners = 50;
constexpr double kSmallestSquareM = 1e-3;
constexpr double kLargestSquareM = 1;

bool in_range(const Board& board) {
  const auto side = [](int corners) {
    return corners >= kFewestCorners && corners <= kMostCorners;
  };
  return side(board.columns) && side(board.rows) && board.square_m >= kSmallestSquareM &&
         board.square_m <= kLargestSquareM;
}

}  // namespace

dataset::Loaded<Board> board_named(std::string_view text) {
  const std::string whole(text);
  const std::size_t cross = text.find('x');
  const std::size_t colon = text.find(':');
  Board board;
  if (cross != std::string_view::npos && colon != std::string_view::npos && cross < colon) {
    board.columns = dsp::parse_number<int>(text.substr(0, cross)).value_or(0);
    board.rows = dsp::parse_number<int>(text.substr(cross + 1, colon - cross - 1)).value_or(0);
    board.square_m = dsp::parse_number<double>(text.substr(colon + 1)).value_or(0);
  }
  if (!in_range(board)) {
    return dataset::refuse("board " + whole +
                           ": is no COLUMNSxROWS:SQUARE_M with 3 to 50 corners a side and squares "
                           "of 0.001 to 1 m: give one such as 9x6:0.030");
  }
  if ((board.columns + board.rows) % 2 == 0) {
    return dataset::refuse("board " + whole +
                           ": looks the same upside down: use one with an odd and an even number "
                           "of corners, such as 9x6");
  }
  return board;
}

std::string to_string(const Board& board) {
  return printed("%dx%d:%g", board.columns, board.rows, board.square_m);
}

}  // namespace stof::host
