#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/match_params.h"

// How rows of pixels become the left and right rows of sad.h, and which candidates exist.
namespace stof::dsp {

// The pictures that are compared: grey values, smoothed or not, or their derivatives. One size.
struct CostPictures {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
};

// Candidates of a column with the unused ones that round them up to whole vectors.
int lanes_of(const MatchParams& params) noexcept;

// The columns of a cost row: those of the picture and, for blocks, some beyond either side, where
// the border replicates. Column k stands for x = k - before.
struct CostColumns {
  int before = 0;
  int after = 0;
};

// The columns that a block as wide as the params' needs.
CostColumns block_columns(const MatchParams& params) noexcept;

// The left row: row.size() + before + after elements. Row not empty.
void extend_row(std::span<const std::uint8_t> row, CostColumns columns,
                std::span<std::uint8_t> out) noexcept;

// The right row, reversed: row.size() + before + after + lanes - 1 elements; candidate i of column
// k, which is right x = k - before - min_disparity - i, is element n - 1 - k + i.
void reverse_row(std::span<const std::uint8_t> row, CostColumns columns, int min_disparity,
                 std::span<std::uint8_t> out) noexcept;

// A left and a right row as above, of blocks as wide as the params'.
struct RowPair {
  std::span<std::uint8_t> left;
  std::span<std::uint8_t> right;

  // For pictures up to `width`.
  static RowPair take(const MatchParams& params, int width, Arena& arena) noexcept;
  // Overwritten with row y of pictures; rows beyond these replicate. Returns what is used.
  RowPair load(const CostPictures& pictures, int y, const MatchParams& params) const noexcept;
};

// kNoCost for candidates whose right column lies outside the picture, and for unused lanes.
// costs: width * lanes, of the picture's own columns; Sum is u8, u16 or u32.
template <typename Sum>
void mark_outside(const MatchParams& params, int width, std::span<Sum> costs) noexcept;

}  // namespace stof::dsp
