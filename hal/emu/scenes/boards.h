#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <string_view>

#include "dataset/image.h"
#include "hal/emu/scenes/scene.h"

// What cameras are calibrated with, as things of a scene: flat sheets of a true size.
namespace stof::hal::emu {

// Its axes: x right, y down, z away from whoever looks at it, so that the identity faces a camera.
// The origin is the first inner corner of a chessboard (top left), the top left corner of another
// print, the middle of a plane.
struct Board {
  enum class Kind : std::uint8_t { kChess, kPrint, kPlane };
  Kind kind = Kind::kPlane;
  int columns = 0;  // inner corners of a chessboard; cells of a print
  int rows = 0;
  double square_m = 0;  // a side of a square; of a cell
  Vec3 half;            // of the sheet, its white margin included
  Vec3 origin;          // from the middle of the sheet
  Vec3 pattern_half;    // what has to be seen of it: without the margin
  Material material;
  std::shared_ptr<const Print> print;
};

// Black squares and white ones, around which one square of white is left. Dark at the top left.
Board chessboard(int columns, int rows, double square_m);

// Any pattern: each pixel of the picture is a square cell. 255 is paper, 0 ink.
Board printed_board(const dataset::Image<std::uint8_t>& picture, double pixel_m);

// A textured wall without an end: fine grain for the pair, of one brightness in infrared.
Board plane();

// plane; board:chess,COLUMNSxROWS,SQUARE_M (inner corners, 2 to 60 a side, 1 mm to 1 m);
// board:print,FILE.pgm,PIXEL_MM (0.01 to 100 mm). Or a line that says what is wrong.
std::expected<Board, std::string> parse_board(std::string_view name);
// Whether the name is meant to be of one of these.
bool is_board(std::string_view name) noexcept;

// The board in the world, and what stands behind it.
SceneObject board_at(const Board& board, const Pose& pose);
Scene behind(const Board& board);

}  // namespace stof::hal::emu
