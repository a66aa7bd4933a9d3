#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"

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

  void clear() noexcept;
  void add(int x, int y, QuarterMm distance) noexcept;
  // After all add(): sums up. Then around() may be asked until clear().
  void sum() noexcept;
  // Votes of the cells around the pixel for distances within half a bin to one bin of this one.
  int around(int x, int y, QuarterMm distance) const noexcept;

 private:
  std::size_t at(int cell_x, int cell_y) const noexcept;

  int cells_x_;
  int cells_y_;
  int bin_bits_ = 0;
  std::size_t bins_ = 0;            // and one at either end that stays 0
  std::span<std::uint16_t> votes_;  // [cell][bin]
  std::span<std::uint16_t> sums_;
  std::span<std::uint16_t> line_;  // sums of three cells of a column
};

}  // namespace stof::dsp
