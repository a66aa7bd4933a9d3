#include "dsp/fusion/temporal/cell_change.h"

#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp {

void check_cell_change(const CellRows& now, const CellRows& then,
                       std::span<const std::uint8_t> changed) noexcept {
  for (std::size_t k = 0; k < now.size(); ++k) {
    STOF_CHECK(now[k].size() >= kCellSize * changed.size() &&
               then[k].size() >= kCellSize * changed.size());
  }
}

namespace ref {

void cell_change(const CellRows& now, const CellRows& then,
                 std::span<std::uint8_t> changed) noexcept {
  check_cell_change(now, then, changed);
  for (std::size_t i = 0; i < changed.size(); ++i) {
    int sum = 0;
    int apart = 0;
    for (std::size_t k = 0; k < now.size(); ++k) {
      for (std::size_t x = kCellSize * i; x < kCellSize * (i + 1); ++x) {
        const int difference = now[k][x] - then[k][x];
        sum += difference;
        apart += std::abs(difference);
      }
    }
    changed[i] = std::abs(sum) > kCellSumStep || apart > kCellPixelStep ? 255 : 0;
  }
}

}  // namespace ref
}  // namespace stof::dsp
