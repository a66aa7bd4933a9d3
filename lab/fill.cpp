#include "lab/fill.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "dsp/base/check.h"

namespace stof::lab {
namespace {

void fill_row(std::span<Disparity> row, std::span<std::uint8_t> filled) noexcept {
  std::size_t x = 0;
  while (x < row.size()) {
    if (row[x].valid()) {
      ++x;
      continue;
    }
    const std::size_t begin = x;
    while (x < row.size() && !row[x].valid()) {
      ++x;
    }
    if (begin == 0 && x == row.size()) {
      return;
    }
    const Disparity before = row[begin == 0 ? x : begin - 1];
    const Disparity after = row[x == row.size() ? begin - 1 : x];
    std::ranges::fill(row.subspan(begin, x - begin), before.raw < after.raw ? before : after);
    std::ranges::fill(filled.subspan(begin, x - begin), std::uint8_t{1});
  }
}

}  // namespace

void fill_from_background(ImageView<Disparity> disparities, Rows rows,
                          ImageView<std::uint8_t> filled) noexcept {
  STOF_CHECK(same_size(disparities, filled) && rows.begin >= 0 && rows.end <= disparities.height());
  for (int y = rows.begin; y < rows.end; ++y) {
    fill_row(disparities.row(y), filled.row(y));
  }
}

}  // namespace stof::lab
