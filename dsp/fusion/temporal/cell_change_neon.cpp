#include "dsp/fusion/temporal/cell_change.h"

#include <cstddef>

#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kCells = 8;  // at once

// Sums of two neighbouring pixels over the rows: of a cell, two lanes.
struct Halves {
  uint16x8_t now = vdupq_n_u16(0);
  uint16x8_t then = vdupq_n_u16(0);
  uint16x8_t apart = vdupq_n_u16(0);
};

Halves of_sixteen(const CellRows& now, const CellRows& then, std::size_t x) noexcept {
  Halves sums;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const uint8x16_t a = vld1q_u8(now[k].data() + x);
    const uint8x16_t b = vld1q_u8(then[k].data() + x);
    sums.now = vpadalq_u8(sums.now, a);
    sums.then = vpadalq_u8(sums.then, b);
    sums.apart = vpadalq_u8(sums.apart, vabdq_u8(a, b));
  }
  return sums;
}

}  // namespace

void cell_change(const CellRows& now, const CellRows& then,
                 std::span<std::uint8_t> changed) noexcept {
  check_cell_change(now, then, changed);
  std::size_t i = 0;
  for (; i + kCells <= changed.size(); i += kCells) {
    const Halves left = of_sixteen(now, then, kCellSize * i);
    const Halves right = of_sixteen(now, then, kCellSize * i + 16);
    const uint16x8_t sum =
        vabdq_u16(vpaddq_u16(left.now, right.now), vpaddq_u16(left.then, right.then));
    const uint16x8_t apart = vpaddq_u16(left.apart, right.apart);
    const uint16x8_t far = vorrq_u16(vcgtq_u16(sum, vdupq_n_u16(kCellSumStep)),
                                     vcgtq_u16(apart, vdupq_n_u16(kCellPixelStep)));
    vst1_u8(changed.data() + i, vmovn_u16(far));
  }
  const auto behind = [i](const CellRows& rows) noexcept {
    CellRows tail = rows;
    for (std::span<const std::uint8_t>& row : tail) {
      row = row.subspan(kCellSize * i);
    }
    return tail;
  };
  ref::cell_change(behind(now), behind(then), changed.subspan(i));
}

}  // namespace stof::dsp::neon
