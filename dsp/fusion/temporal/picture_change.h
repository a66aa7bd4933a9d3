#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// Where a picture has changed since it was last seen otherwise, by pixels (pixel_change.h) and by
// cells (cell_change.h), and whether so much of it has that the camera itself moved. Both are
// compared with what they showed when they last changed, so that slow changes add up. 2.1 bytes a
// pixel.
class PictureChange {
 public:
  // What changes within so many cells of a pixel counts as its change: a body of one colour changes
  // at its outline.
  static constexpr int kReach = 2;
  // Where more than a quarter of the cells change at once, the camera moves.
  static constexpr int kMovedShare = 4;

  // Of a pixel: one of the 3x3 around it has changed; a cell within kReach has.
  enum Mark : std::uint8_t { kPixel = 1, kCell = 2 };

  PictureChange(int width, int height, Arena& arena) noexcept;

  // Looks at the next picture. false: the camera moved, or there is no picture before this one;
  // then nothing is marked.
  bool look(ImageView<const std::uint8_t> picture) noexcept;
  // The next picture has none before it.
  void forget() noexcept { knows_ = false; }

  // Marks of row y.
  void mark(int y, std::span<std::uint8_t> marks) const noexcept;

 private:
  void take(ImageView<const std::uint8_t> picture) noexcept;
  void take_changed(ImageView<const std::uint8_t> picture) noexcept;
  int compare(ImageView<const std::uint8_t> picture) noexcept;
  void widen() noexcept;

  ImageView<std::uint8_t> before_;
  ImageView<std::uint8_t> pixels_;   // that have changed
  std::span<std::uint8_t> rows_;     // not 0: some of its pixels have
  ImageView<std::uint8_t> changed_;  // of each cell
  ImageView<std::uint8_t> around_;   // of each cell, by what has changed around it
  std::span<std::uint8_t> column_;   // of a row of cells, with kReach more at either end
  bool knows_ = false;
};

}  // namespace stof::dsp
