#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// The memory of drop_speckles(): 4 bytes a pixel and some rows.
struct SpeckleScratch {
  // The state of one row. A run is a row of connected pixels; runs of the image are numbered
  // from the top, from left to right.
  struct Line {
    std::span<std::int16_t> raw;  // a pixel before the row, the row, and behind it none
    std::span<std::uint64_t> valid;
    std::span<std::uint64_t> begins;  // the first pixels of runs
    std::span<std::int32_t> runs;     // how many begin before this word, from the top
  };

  SpeckleScratch() = default;
  // For maps up to width x height.
  SpeckleScratch(int width, int height, Arena& arena) noexcept;

  std::span<std::int32_t> links;  // one for each run
  std::array<Line, 2> lines;
};

// Drops connected patches of fewer than min_pixels pixels. Two pixels are connected when they share
// a side and their disparities differ by at most 1 px; a patch may span more. Time does not depend
// on the patches' shapes or sizes; no recursion.
void drop_speckles(ImageView<Disparity> disparities, int min_pixels,
                   SpeckleScratch& scratch) noexcept;

}  // namespace stof::dsp
