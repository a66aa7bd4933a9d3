#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "lab/dsp_names.h"

namespace stof::lab {

// Summed-area table of u8 values: the sum over any rectangle from four look-ups. u32 sums wrap and
// their differences stay right as long as one rectangle's sum fits.
class Integral {
 public:
  Integral(int width, int height, Arena& arena) noexcept
      : stride_(static_cast<std::size_t>(width) + 1),
        sums_(arena.take<std::uint32_t>(elements(width, height))) {}

  // Rows come in order, from 0.
  void add_row(std::span<const std::uint8_t> row, int y) noexcept {
    if (y == 0) {
      std::ranges::fill(sums_.first(stride_), 0U);
    }
    const std::span<const std::uint32_t> above =
        sums_.subspan(static_cast<std::size_t>(y) * stride_, stride_);
    const std::span<std::uint32_t> here =
        sums_.subspan((static_cast<std::size_t>(y) + 1) * stride_, stride_);
    std::uint32_t sum = 0;
    here[0] = 0;
    for (std::size_t x = 0; x < row.size(); ++x) {
      sum += row[x];
      here[x + 1] = above[x + 1] + sum;
    }
  }

  // Over columns [left, right) and rows [top, bottom).
  std::uint32_t sum(int left, int top, int right, int bottom) const noexcept {
    return at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
  }

 private:
  static std::size_t elements(int width, int height) noexcept {
    return (static_cast<std::size_t>(width) + 1) * (static_cast<std::size_t>(height) + 1);
  }
  std::uint32_t at(int x, int y) const noexcept {
    return sums_[static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x)];
  }

  std::size_t stride_;
  std::span<std::uint32_t> sums_;
};

}  // namespace stof::lab
