#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/base/index.h"

namespace stof::dsp {

// Sums of signed 16-bit values over a window of kWindow x kWindow pixels about every pixel of a
// row: x - 12 .. x + 11 and rows alike, borders replicate. Rows enter and leave one by one; the
// sums are exact, so they do not depend on where the walk begins. |sum| < 2^25.
class WindowSums {
 public:
  static constexpr int kWindow = 24;
  static constexpr int kBefore = kWindow / 2;  // columns or rows before the centre
  static constexpr int kArea = kWindow * kWindow;

  WindowSums() = default;
  // For rows of up to `width` columns.
  WindowSums(int width, Arena& arena) noexcept
      : all_columns_(arena.take_passing<std::int32_t>(index(width))),
        padded_(arena.take_passing<std::int32_t>(index(width) + kWindow - 1)),
        values_(arena.take_passing<std::int16_t>(index(width))) {}

  // Forgets all rows; the next ones have so many columns.
  void start(int width) noexcept {
    columns_ = all_columns_.first(index(width));
    std::ranges::fill(columns_, 0);
  }
  // A row for whoever has to make what enters and leaves.
  std::span<std::int16_t> values() const noexcept { return values_.first(columns_.size()); }

  // row: one value per column.
  void enter(std::span<const std::int16_t> row) noexcept;
  void leave(std::span<const std::int16_t> row) noexcept;
  // One sum per column over the rows that have entered and not left. Valid until the next call.
  std::span<const std::int32_t> sums() noexcept;

 private:
  std::span<std::int32_t> all_columns_;
  std::span<std::int32_t> columns_;  // those of the current rows
  std::span<std::int32_t> padded_;
  std::span<std::int16_t> values_;
};

// Calls use(y, sums) for each of `rows` of an image of `height` rows; row_of(y) gives the values of
// a row as std::span<const std::int16_t>, valid until its next call. `window` has started.
template <typename RowOf, typename Use>
void for_each_window_row(int height, Rows rows, WindowSums& window, RowOf row_of,
                         Use use) noexcept {
  const auto clamped = [&](int y) noexcept { return row_of(std::clamp(y, 0, height - 1)); };
  const int above = rows.begin - WindowSums::kBefore;
  for (int y = above; y < above + WindowSums::kWindow - 1; ++y) {
    window.enter(clamped(y));
  }
  for (int y = rows.begin; y < rows.end; ++y) {
    const int first = y - WindowSums::kBefore;
    window.enter(clamped(first + WindowSums::kWindow - 1));
    use(y, window.sums());
    window.leave(clamped(first));
  }
}

}  // namespace stof::dsp
