#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/resolve/match_evidence.h"

namespace stof::dsp {

// What gather() and fill() read beside the map. All images of its size.
struct HoleView {
  ImageView<const Disparity> disparity;
  ImageView<const QuarterMm> pmd_low;  // the PMD's interval, max(low, 1) > high where there is none
  ImageView<const QuarterMm> pmd_high;
};

// Gives pixels that neither sensor could tell the depth of a surface around them, where what the
// PMD reads there, too weak to be published, allows it. Such a depth is a guess, so its interval
// holds every surface that it might be; where these leave more than a metre open, there is none.
//
// A map is divided into cells of 8x8 px. Pixels whose width is at most a sixth of their depth are
// the surfaces of a cell, as far as they are told: from the nearest to the farthest of them, or
// their middle, where the nearest is within a fourteenth of the farthest. Each of the cells with
// open pixels looks in eight directions for the nearest cell with a surface, and asks MatchEvidence
// for each: where a folded reading confirms one, the others do not count; nor do those that are
// contradicted. The fourth farthest is the guess (the nearest of fewer): what only the left camera
// sees belongs to the background, and up to three far ones that are wrong do not spoil it.
//
// Open pixels, and what they become:
//   kNone, or kConflict by kMixedPixel  kResolved; kRangeAmbiguous where a folded reading confirms
//       the guess (in that quarter of the cell): what it reads, 2 sigma and 3 percent; else
//       kInterpolated, where the PMD sees something there that may be the guess: an interval that
//       holds all surfaces that may be meant, of at least three, and a quarter of the depth to
//       either side; up to 4 m, where that is a metre. What reflects no light and has no texture
//       may stand before all of them
//   kPmd whose interval is wider than a twelfth, and kResolved by kMixedPixel without a match: if
//       the PMD's interval holds the guess, it is taken, with an interval that holds the PMD's;
//       in place of a kPmd moved towards its depth by at most a 64th of it;
//       kResolved, kMixedPixel where that was the cause, else kStereoAmbiguous
// First, where PMD pixels are fine, guesses of before become holes: a kPmd as above, and a
// kResolved by kMixedPixel, kStereoAmbiguous or kOccluded. One is dropped (kConflict, kMixedPixel)
// where a surface of its cell or of the eight around it is nearer by over a metre, and so do the
// PMD's intervals end at two or more of the 16 pixels 4 and 8 px around it: it is beside an edge,
// and may be of what is near.
//
// Others stay as they are, as do those where what might be there, or any surface up to two cells
// away, is nearer than the guess by more than a metre: the pixel may be of its edge.
//
// Holds a sixteenth of a byte a pixel.
class HoleFiller {
 public:
  // Maps of this size, depths up to max_range.
  HoleFiller(int width, int height, QuarterMm max_range, Arena& arena) noexcept;

  // Rows of cells, for who splits them.
  Rows cell_rows() const noexcept { return near_.rows(); }
  // Rows of the map in them.
  Rows map_rows(Rows cells) const noexcept;

  // First gather() all rows of cells of a map, then fill() them; either in any order and by any
  // split. map: with causes.
  void gather(Rows cells, const DepthMap& map) const noexcept;
  void fill(Rows cells, const HoleView& view, const MatchEvidence& evidence,
            const DepthMap& map) const noexcept;

 private:
  // Where a cell's surfaces may be; depth 0: nowhere.
  struct Guess {
    QuarterMm depth = 0;
    int half = 0;        // of the interval
    bool read = false;   // confirmed by a folded reading
    bool fills = false;  // holes
  };
  class Search;
  // What a quarter of a cell reads of a confirmed guess.
  Guess read(const Guess& guess, const MatchEvidence& evidence, int column, int row) const noexcept;
  class OpenRow;
  struct OpenCells;
  void drop_guesses(int row, const HoleView& view, OpenCells& open) const noexcept;
  static void drop_guesses(std::size_t first, int y, int most, const HoleView& view,
                           OpenCells& open) noexcept;
  void fill_cell(int column, int row, const Guess& guess, const OpenCells& open,
                 const MatchEvidence& evidence) const noexcept;
  // Open pixels of the cell that begins in column x, a bit each: rows of eight, the first lowest.
  struct OpenBits {
    std::size_t x;
    std::uint64_t hole;
    std::uint64_t loose;
  };
  void fill_quarter(const Guess& guess, const OpenBits& bits, const OpenCells& open) const noexcept;

  // Of each cell, 0 without a surface.
  ImageView<QuarterMm> near_;
  ImageView<QuarterMm> far_;  // or the middle
  int width_ = 0;
  int height_ = 0;
  QuarterMm max_range_ = 0;
};

}  // namespace stof::dsp
