#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "lab/dsp_names.h"

namespace stof::lab {

// Makes a map dense. A pixel without a disparity takes the third smallest (farthest) of the nearest
// valid ones in eight directions, or the largest of fewer: what only one camera sees belongs to the
// background, and one or two far matches that are wrong do not spoil a hole. In the spirit of
// Hirschmueller 2008, section 2.5.3, who takes the second. Holds its buffers.
class Filler {
 public:
  Filler(int width, int height, Arena& arena) noexcept;

  // filled becomes 1 where a value is made up and stays as it is elsewhere. Equal sizes, at most
  // the constructor's. A map without any valid disparity stays as it is.
  void fill(ImageView<Disparity> disparities, ImageView<std::uint8_t> filled) noexcept;

 private:
  static constexpr std::size_t kAcross = 3;  // directions: column - 1, the same, column + 1
  // The nearest valid ones of a pixel, those before it in its row and in the rows before.
  using Nearest = std::array<Disparity, 1 + kAcross>;
  struct Front {
    std::array<Disparity, kAcross> nearest;  // that of the pixel itself included
  };

  Nearest look(std::size_t x, Disparity in_row) const noexcept;
  void pass(std::span<const Disparity> row) noexcept;

  std::span<Nearest> first_;     // of all pixels, from the upper left
  std::span<Front> front_;       // of the row that was passed last
  std::span<Front> next_;        // of the row that is being passed
  std::span<Disparity> before_;  // a row before it is filled
};

}  // namespace stof::lab
