#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/cost/pixel_costs.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

namespace stof::lab {

// The costs of fixed blocks, one row of the picture at a time, for every Cost: the sum
// over the block_width x block_height pixels around (x, y) of what left (x, y) and right (x - d, y)
// differ by; borders of both pictures replicate. Block and cost are all it reads of its params,
// beside the range of disparities and, for the size of sums, prefilter_cap.
//
// Holds its buffers, allocates nothing. Sums slide from a row to the next one; any other row starts
// anew, at the price of block_height rows. The result does not depend on the order.
class CostRows {
 public:
  // Whether sums are u32: those that could reach kNoCost of u16.
  static bool wide(const MatchParams& params) noexcept;

  // params pass check(), for pictures up to `width`. Census and AD-Census keep block_height + 1
  // rows of pixel costs; SAD and SSD compute again what leaves the block.
  CostRows(const MatchParams& params, int width, Arena& arena) noexcept;

  // Another pair of pictures, at most the constructor's width, that match prefilter_cap: values of
  // `left` and `right` stay below 2 cap + 1 where it is set.
  void start(const CostPictures& pictures) noexcept;

  int lanes() const noexcept { return lanes_; }

  // Row y, inside the picture, laid out [x][candidate], width * lanes() sums, kNoCost where a
  // candidate lies outside the right picture or a lane is unused. Sum is std::uint32_t when
  // wide(params), else std::uint16_t. Valid until the next call.
  template <typename Sum>
  std::span<const Sum> row(int y) noexcept;

 private:
  template <typename Sum>
  struct Sums {
    std::span<Sum> columns;  // of all rows of the block, for the columns of the widened picture
    std::span<Sum> costs;    // of the block
  };

  template <typename Sum>
  Sums<Sum> sums() const noexcept;
  template <typename Sum>
  void enter(int y, std::span<Sum> columns) noexcept;
  template <typename Sum>
  void exchange(int entering, int leaving, std::span<Sum> columns) noexcept;
  std::span<std::uint8_t> kept(int y) const noexcept;
  std::size_t widened() const noexcept;

  MatchParams params_;
  int width_;
  int lanes_;
  CostColumns columns_;
  std::optional<PixelCosts> pixels_;
  std::span<std::uint8_t> kept_;  // rows of pixel costs, where there are pixels_
  RowPair new_;                   // pixels of the rows that enter and leave, where there are not
  RowPair old_;
  Sums<std::uint16_t> narrow_sums_;  // one of them is empty
  Sums<std::uint32_t> wide_sums_;

  CostPictures pictures_;
  std::optional<int> y_;  // the row that the sums stand for
};

extern template std::span<const std::uint16_t> CostRows::row(int y) noexcept;
extern template std::span<const std::uint32_t> CostRows::row(int y) noexcept;

}  // namespace stof::lab
