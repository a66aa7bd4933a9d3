#include "hal/emu/scenes/boards.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/base/parse_number.h"

namespace stof::hal::emu {
namespace {

constexpr std::string_view kBoard = "board:";
constexpr std::string_view kChess = "chess,";
constexpr std::string_view kPrinted = "print,";
constexpr int kLeastCorners = 2;  // a side
constexpr int kMostCorners = 60;
constexpr double kMmPerM = 1000;

// Paper and toner, in infrared as in the light that one sees.
constexpr Material kSheet{.albedo = 0.85, .contrast = 0.93, .texture = Texture::kPrint};

Board sheet_of(Print print) {
  Board board;
  const double cell = print.cell_m;
  board.columns = print.columns;
  board.rows = print.rows;
  board.square_m = cell;
  board.half = {print.columns * cell / 2, print.rows * cell / 2, 0};
  board.pattern_half = board.half;
  board.origin = -1 * board.half;
  board.material = kSheet;
  board.print = std::make_shared<const Print>(std::move(print));
  board.material.print = board.print.get();
  return board;
}

std::unexpected<std::string> wrong(std::string_view name) {
  std::string line("there is no board \"");
  line += name;
  line +=
      "\": take board:chess,COLUMNSxROWS,SQUARE_M (inner corners, 2 to 60 a side, 0.001 to 1 m), "
      "board:print,FILE.pgm,PIXEL_MM (0.01 to 100 mm) or plane";
  return std::unexpected(std::move(line));
}

// COLUMNSxROWS,SQUARE_M.
std::optional<Board> parse_chess(std::string_view text) {
  const std::size_t times = text.find('x');
  const std::size_t comma = text.find(',');
  if (times == std::string_view::npos || comma == std::string_view::npos || times > comma) {
    return std::nullopt;
  }
  const auto columns =
      dsp::parse_number_in<int>(text.substr(0, times), kLeastCorners, kMostCorners);
  const auto rows = dsp::parse_number_in<int>(text.substr(times + 1, comma - times - 1),
                                              kLeastCorners, kMostCorners);
  const auto square = dsp::parse_number_in<double>(text.substr(comma + 1), 0.001, 1);
  return columns && rows && square ? std::optional(chessboard(*columns, *rows, *square))
                                   : std::nullopt;
}

}  // namespace

Board chessboard(int columns, int rows, double square_m) {
  constexpr int kMargin = 1;  // squares
  Print print{.columns = columns + 1 + 2 * kMargin,
              .rows = rows + 1 + 2 * kMargin,
              .cell_m = square_m,
              .cells = {}};
  for (int y = -kMargin; y <= rows + kMargin; ++y) {
    for (int x = -kMargin; x <= columns + kMargin; ++x) {
      const bool inside = x >= 0 && x <= columns && y >= 0 && y <= rows;
      print.cells.push_back(inside && (x + y) % 2 == 0 ? 0 : 255);
    }
  }
  Board board = sheet_of(std::move(print));
  board.kind = Board::Kind::kChess;
  board.columns = columns;
  board.rows = rows;
  board.origin = {-(columns - 1) * square_m / 2, -(rows - 1) * square_m / 2, 0};
  board.pattern_half = {(columns + 1) * square_m / 2, (rows + 1) * square_m / 2, 0};
  return board;
}

Board printed_board(const dataset::Image<std::uint8_t>& picture, double pixel_m) {
  Board board = sheet_of({.columns = picture.width,
                          .rows = picture.height,
                          .cell_m = pixel_m,
                          .cells = picture.pixels});
  board.kind = Board::Kind::kPrint;
  return board;
}

Board plane() {
  constexpr double kWide = 20;  // more than any camera sees
  Board board;
  board.half = {kWide, kWide, 0};
  board.material = {.albedo = 0.8,
                    .contrast = 0.75,
                    .texture = Texture::kSpeckle,
                    .period_m = 0.4,
                    .seed = 11,
                    .nir = 0.7};
  return board;
}

bool is_board(std::string_view name) noexcept {
  return name == "plane" || name.starts_with(kBoard);
}

std::expected<Board, std::string> parse_board(std::string_view name) {
  if (name == "plane") {
    return plane();
  }
  if (!name.starts_with(kBoard)) {
    return wrong(name);
  }
  const std::string_view rest = name.substr(kBoard.size());
  if (rest.starts_with(kChess)) {
    const std::optional<Board> board = parse_chess(rest.substr(kChess.size()));
    return board ? std::expected<Board, std::string>(*board) : wrong(name);
  }
  const std::size_t comma = rest.rfind(',');
  if (!rest.starts_with(kPrinted) || comma < kPrinted.size()) {
    return wrong(name);
  }
  const auto pixel_mm = dsp::parse_number_in<double>(rest.substr(comma + 1), 0.01, 100);
  if (!pixel_mm) {
    return wrong(name);
  }
  const std::string file(rest.substr(kPrinted.size(), comma - kPrinted.size()));
  const dataset::Loaded<dataset::Image<std::uint8_t>> picture = dataset::read_pgm8(file);
  if (!picture) {
    return std::unexpected(picture.error().message);
  }
  return printed_board(*picture, *pixel_mm / kMmPerM);
}

SceneObject board_at(const Board& board, const Pose& pose) {
  return {.shape = Shape::kRectangle,
          .pose = pose * Pose{.rotation = Pose{}.rotation, .position = -1 * board.origin},
          .half = board.half,
          .material = board.material};
}

Scene behind(const Board& board) {
  Scene scene;
  if (board.kind == Board::Kind::kPlane) {
    scene.ambient = 0.7;
    return scene;
  }
  constexpr double kWallZ = 5;
  constexpr double kWide = 20;
  scene.ambient = 0.55;
  scene.lights.push_back({.position = {-0.6, -1.2, -0.4}, .power = 0.5});
  add(scene, Shape::kRectangle, {0, 0, kWallZ}, {kWide, kWide, 0},
      {.albedo = 0.6, .contrast = 0.5, .texture = Texture::kNoise, .period_m = 0.5, .seed = 3});
  scene.prints.push_back(board.print);
  return scene;
}

}  // namespace stof::hal::emu
