#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/image.h"
#include "host/calibrate/rig/target/board.h"

// A board on paper, in true size, with a ruler that tells whether it was printed so.
namespace stof::host {

struct Rectangle {
  double x_mm = 0;  // of the upper left corner, from that of the sheet
  double y_mm = 0;
  double width_mm = 0;
  double height_mm = 0;
};
struct SheetText {
  double x_mm = 0;
  double y_mm = 0;  // of the baseline
  double size_mm = 0;
  std::string text;  // ASCII
};
struct Sheet {
  double width_mm = 0;
  double height_mm = 0;
  std::vector<Rectangle> black{};
  std::vector<Rectangle> white{};  // on top of the black ones
  std::vector<SheetText> texts{};
};

// "a4", "a3", "a2", "a1", "a0"; the board lies as it fits best. One line where the paper is none of
// these, or too small: one square of white stays around the board.
dataset::Loaded<Sheet> sheet_of(const Board& board, std::string_view paper);

// The sheet as PDF: vectors and a standard font, one page.
std::string pdf_bytes(const Sheet& sheet);

// The board alone as a picture, with white around it, in the fewest pixels that show each of its
// cells as whole ones; nothing where a marker's side is no simple share of its square. For the
// emulator
// (`board:print,FILE.pgm,PIXEL_MM`).
struct BoardPicture {
  dataset::Image<std::uint8_t> picture;
  double pixel_mm = 0;
};
std::optional<BoardPicture> picture_of(const Board& board);

}  // namespace stof::host
