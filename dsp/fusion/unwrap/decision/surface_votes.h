#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/index.h"
#include "dsp/fusion/unwrap/wrap_maps.h"

namespace stof::dsp {

// How a reading goes on in the one to its right or below, in one number: -1, 0, 1, the gain, where
// both lie within their noise in distance and in amplitude: wraps(other) = wraps(this) + gain,
// not 0 where distance wraps. Else:
inline constexpr std::int8_t kDimmed = 2;   // within some slope, and amplitude at most doubles
inline constexpr std::int8_t kBlurred = 3;  // their noise hides any edge
inline constexpr std::int8_t kBroken = 4;
using SurfaceLink = std::int8_t;
constexpr bool goes_on(SurfaceLink link) noexcept { return link < kDimmed; }

// Pixels around a pixel that see the same surface: those in the rows which its column reaches
// without a break, as far as these reach without one, up to kArm pixels each way. Counted by what
// they voted for.
class SurfaceVotes {
 public:
  static constexpr int kArm = 6;
  // Pixels counted around a pixel: how many voted for each wrap count, and in the last element all,
  // voters or not.
  using Counts = std::array<std::uint16_t, kMostWrapCounts + 1>;

  SurfaceVotes(int width, int height, Arena& arena) noexcept;

  // To be filled for every row: links of its pixels to the right and to the row below; kBroken in
  // the last column, the last row.
  std::span<SurfaceLink> right_row(int y) const noexcept { return row_of(right_, y); }
  std::span<SurfaceLink> below_row(int y) const noexcept { return row_of(below_, y); }
  SurfaceLink right(std::size_t pixel) const noexcept { return right_[pixel]; }
  SurfaceLink below(std::size_t pixel) const noexcept { return below_[pixel]; }

  // After all rows: sums up votes for wrap counts 0 .. wrap_counts - 1, below 0 = none.
  void sum(std::span<const std::int8_t> votes, int wrap_counts) noexcept;
  Counts around(int x, int y) const noexcept;

 private:
  std::span<SurfaceLink> row_of(std::span<SurfaceLink> links, int y) const noexcept {
    const std::size_t row = index(width_);
    return links.subspan(index(y) * row, row);
  }
  void reach() noexcept;
  void sum_row(int y, std::span<const std::int8_t> votes) noexcept;

  int width_;
  int height_;
  std::span<SurfaceLink> right_;
  std::span<SurfaceLink> below_;
  std::span<std::uint8_t> left_arm_;
  std::span<std::uint8_t> right_arm_;
  std::span<std::uint8_t> upper_arm_;
  std::span<std::uint8_t> lower_arm_;
  std::span<std::uint8_t> whole_;  // of a row: 1 where it goes on to the right; a border of 0
  // Sums hold four counts of 16 bits in a word: the first of all pixels, then one for each
  // wrap count.
  std::size_t words_ = 1;             // of a pixel
  std::span<std::uint64_t> line_;     // of a row from its left
  std::span<std::uint64_t> columns_;  // of what lies along the arms of rows, from the top
};

}  // namespace stof::dsp
