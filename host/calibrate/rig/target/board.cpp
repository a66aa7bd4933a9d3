#include "host/calibrate/rig/target/board.h"

#include <algorithm>
#include <optional>

#include "dataset/files/file.h"
#include "dsp/base/parse_number.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kFewestCorners = 3;
constexpr int kMostCorners = 50;
constexpr int kFewestTags = 2;
constexpr int kMostTags = 20;  // 400 of the 587 that there are
constexpr double kSmallestSquareM = 1e-3;
constexpr double kLargestSquareM = 1;
constexpr double kMarkerShare = 0.75;
constexpr double kLeastMarkerShare = 0.3;
constexpr double kMostMarkerShare = 0.9;
constexpr double kLeastGap = 0.1;
constexpr double kMostGap = 1;
constexpr int kMarkerBits = 4;
constexpr std::size_t kMostMarkers = 1000;  // of OpenCV's dictionaries

constexpr std::string_view kCharuco = "charuco:";
constexpr std::string_view kAprilGrid = "aprilgrid:";

std::vector<std::string_view> parts_of(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

bool put_grid(std::string_view text, int least, int most, Board& board) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) {
    return false;
  }
  const auto columns = dsp::parse_number_in<int>(text.substr(0, cross), least, most);
  const auto rows = dsp::parse_number_in<int>(text.substr(cross + 1), least, most);
  board.columns = columns.value_or(0);
  board.rows = rows.value_or(0);
  return columns && rows;
}

bool put_square(std::string_view text, Board& board) {
  const auto square = dsp::parse_number_in<double>(text, kSmallestSquareM, kLargestSquareM);
  board.square_m = square.value_or(0);
  return square.has_value();
}

std::optional<Board> charuco_of(const std::vector<std::string_view>& parts) {
  Board board{.kind = Board::Kind::kCharuco, .share = kMarkerShare, .bits = kMarkerBits};
  if (parts.size() < 2 || parts.size() > 4 ||
      !put_grid(parts[0], kFewestCorners, kMostCorners, board) || !put_square(parts[1], board)) {
    return std::nullopt;
  }
  if (parts.size() > 2) {
    board.share = dsp::parse_number<double>(parts[2]).value_or(0) / board.square_m;
  }
  if (parts.size() > 3) {
    board.bits = parts[3] == "4x4" ? 4 : 0;
    board.bits = parts[3] == "5x5" ? 5 : board.bits;
    board.bits = parts[3] == "6x6" ? 6 : board.bits;
  }
  const bool good = board.bits != 0 && markers_of(board).size() <= kMostMarkers &&
                    board.share >= kLeastMarkerShare && board.share <= kMostMarkerShare;
  return good ? std::optional(board) : std::nullopt;
}

std::optional<Board> april_grid_of(const std::vector<std::string_view>& parts) {
  Board board{.kind = Board::Kind::kAprilGrid};
  if (parts.size() != 3 || !put_grid(parts[0], kFewestTags, kMostTags, board) ||
      !put_square(parts[1], board)) {
    return std::nullopt;
  }
  board.columns *= 2;
  board.rows *= 2;
  board.share = dsp::parse_number_in<double>(parts[2], kLeastGap, kMostGap).value_or(0);
  return board.share > 0 ? std::optional(board) : std::nullopt;
}

std::optional<Board> chessboard_of(const std::vector<std::string_view>& parts) {
  Board board;
  const bool good = parts.size() == 2 && put_grid(parts[0], kFewestCorners, kMostCorners, board) &&
                    put_square(parts[1], board);
  return good ? std::optional(board) : std::nullopt;
}

}  // namespace

dataset::Loaded<Board> board_named(std::string_view text) {
  const std::string whole(text);
  std::optional<Board> board;
  if (text.starts_with(kCharuco)) {
    board = charuco_of(parts_of(text.substr(kCharuco.size())));
  } else if (text.starts_with(kAprilGrid)) {
    board = april_grid_of(parts_of(text.substr(kAprilGrid.size())));
  } else {
    board = chessboard_of(parts_of(text));
  }
  if (!board) {
    return dataset::refuse(
        "board " + whole +
        ": is no COLUMNSxROWS:SQUARE_M with 3 to 50 corners a side and squares of 0.001 to 1 m, no "
        "charuco:COLUMNSxROWS:SQUARE_M[:MARKER_M[:4x4]] and no aprilgrid:COLUMNSxROWS:TAG_M:GAP "
        "with 2 to 20 tags a side: give one such as 9x6:0.030");
  }
  if (!board->has_markers() && (board->columns + board->rows) % 2 == 0) {
    return dataset::refuse("board " + whole +
                           ": looks the same upside down: use one with an odd and an even number "
                           "of corners, such as 9x6");
  }
  return *board;
}

std::string to_string(const Board& board) {
  switch (board.kind) {
    case Board::Kind::kCharuco:
      return printed("charuco:%dx%d:%g:%g:%dx%d", board.columns, board.rows, board.square_m,
                     board.share * board.square_m, board.bits, board.bits);
    case Board::Kind::kAprilGrid:
      return printed("aprilgrid:%dx%d:%g:%g", board.columns / 2, board.rows / 2, board.square_m,
                     board.share);
    case Board::Kind::kChess:
      break;
  }
  return printed("%dx%d:%g", board.columns, board.rows, board.square_m);
}

double marker_side_m(const Board& board) {
  return board.kind == Board::Kind::kCharuco ? board.share * board.square_m : board.square_m;
}

std::vector<BoardMarker> markers_of(const Board& board) {
  std::vector<BoardMarker> markers;
  if (board.kind == Board::Kind::kAprilGrid) {
    const int columns = board.columns / 2;
    const int rows = board.rows / 2;
    for (int id = 0; id < columns * rows; ++id) {
      const int row = rows - 1 - id / columns;
      const int column = id % columns;
      const std::array<double, 2> at = board.at(2 * row * board.columns + 2 * column);
      markers.push_back({.id = id, .x_m = at[0], .y_m = at[1], .column = column, .row = row});
    }
  }
  if (board.kind == Board::Kind::kCharuco) {
    const double inset = (1 - board.share) / 2;
    for (int row = 0; row <= board.rows; ++row) {
      for (int column = 0; column <= board.columns; ++column) {
        if ((row + column) % 2 != 0) {
          markers.push_back({.id = static_cast<int>(markers.size()),
                             .x_m = (column - 1 + inset) * board.square_m,
                             .y_m = (row - 1 + inset) * board.square_m,
                             .column = column,
                             .row = row});
        }
      }
    }
  }
  return markers;
}

}  // namespace stof::host
