#include "dsp/stereo/refine/median.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// x, y: a valid pixel.
Disparity median(ImageView<const Disparity> in, int x, int y) noexcept {
  std::array<std::int16_t, 9> values{};
  std::size_t count = 0;
  for (int row = std::max(y - 1, 0); row < std::min(y + 2, in.height()); ++row) {
    for (int column = std::max(x - 1, 0); column < std::min(x + 2, in.width()); ++column) {
      const Disparity neighbour = in.at(column, row);
      if (neighbour.valid()) {
        values[count] = neighbour.raw;
        ++count;
      }
    }
  }
  std::ranges::sort(std::span(values).first(count));
  return Disparity::from_raw(values[(count - 1) / 2]);
}

}  // namespace

void median_disparity_columns(ImageView<const Disparity> in, int y, int begin, int end,
                              ImageView<Disparity> out) noexcept {
  for (int x = begin; x < end; ++x) {
    out.at(x, y) = in.at(x, y).valid() ? median(in, x, y) : Disparity::none();
  }
}

namespace ref {

void median_disparity(ImageView<const Disparity> in, Rows rows, ImageView<Disparity> out) noexcept {
  STOF_CHECK(same_size(in, out) && rows.begin >= 0 && rows.end <= in.height());
  for (int y = rows.begin; y < rows.end; ++y) {
    median_disparity_columns(in, y, 0, in.width(), out);
  }
}

}  // namespace ref
}  // namespace stof::dsp
