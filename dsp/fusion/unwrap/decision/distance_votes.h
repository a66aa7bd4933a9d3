#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/index.h"

namespace stof::dsp {

// How many readings around a pixel were decided to lie at about a distance: counts by distance for
// cells of kCell x kCell pixels, and their sums over 3 x 3 cells.
class DistanceVotes {
 public:
  static constexpr int kCell = 4;
  static constexpr int kMostBins = 64;

  // range: after how much readings repeat, quarter mm. A bin is at most a sixth of it, unless
  // there would be more than kMostBins.
  DistanceVotes(int width, int height, std::uint32_t range, Arena& arena) noexcept;

  // The sums of the cells around a pixel.
  class Around {
   public:
    Around(const std::uint16_t* sums, int bin_bits) noexcept : sums_(sums), bin_bits_(bin_bits) {}
    // Votes for distances within half a bin to one bin of this one.
    int of(QuarterMm distance) const noexcept {
      // Of a bin's lower half the bin below is the nearer neighbour, of its upper half the one
      // above.
      const int half = 1 << (bin_bits_ - 1);
      const std::size_t bin = index((distance + half) >> bin_bits_);
      return sums_[bin] + sums_[bin + 1];
    }

   private:
    const std::uint16_t* sums_;
    int bin_bits_;
  };

  void clear() noexcept;
  void add(int x, int y, QuarterMm distance) noexcept {
    ++votes_[at(x / kCell, y / kCell) + index(distance >> bin_bits_) + 1];
  }
  // After all add(): sums up. Then around() may be asked until clear().
  void sum() noexcept;
  Around around(int x, int y) const noexcept {
    return {&sums_[at(x / kCell, y / kCell)], bin_bits_};
  }

 private:
  std::size_t at(int cell_x, int cell_y) const noexcept {
    return (pixel_count(cell_y, cells_x_) + index(cell_x)) * bins_;
  }

  int cells_x_;
  int cells_y_;
  int bin_bits_ = 0;
  std::size_t bins_ = 0;            // and one at either end that stays 0
  std::span<std::uint16_t> votes_;  // [cell][bin]
  std::span<std::uint16_t> sums_;
  std::span<std::uint16_t> line_;  // sums of three cells of a column
};

}  // namespace stof::dsp
