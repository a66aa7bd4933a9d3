#include "lab/cost/ssd.h"

#include <cstddef>

#include "dsp/base/simd.h"
#include "lab/cost/slide_rows_neon.h"

namespace stof::dsp::neon {
namespace {

struct Squares {
  uint16x8_t low;
  uint16x8_t high;
};

Squares squares(uint8x16_t a, uint8x16_t b) noexcept {
  const uint8x16_t difference = vabdq_u8(a, b);
  const uint8x8_t low = vget_low_u8(difference);
  const uint8x8_t high = vget_high_u8(difference);
  return {vmull_u8(low, low), vmull_u8(high, high)};
}

// sums += entering.
void accumulate(const Squares& entering, std::uint16_t* sums) noexcept {
  vst1q_u16(sums, vaddq_u16(vld1q_u16(sums), entering.low));
  vst1q_u16(sums + 8, vaddq_u16(vld1q_u16(sums + 8), entering.high));
}
void accumulate(const Squares& entering, std::uint32_t* sums) noexcept {
  vst1q_u32(sums, vaddw_u16(vld1q_u32(sums), vget_low_u16(entering.low)));
  vst1q_u32(sums + 4, vaddw_u16(vld1q_u32(sums + 4), vget_high_u16(entering.low)));
  vst1q_u32(sums + 8, vaddw_u16(vld1q_u32(sums + 8), vget_low_u16(entering.high)));
  vst1q_u32(sums + 12, vaddw_u16(vld1q_u32(sums + 12), vget_high_u16(entering.high)));
}

// sums += entering - leaving.
void exchange(const Squares& entering, const Squares& leaving, std::uint16_t* sums) noexcept {
  accumulate({vsubq_u16(entering.low, leaving.low), vsubq_u16(entering.high, leaving.high)}, sums);
}
void exchange(const Squares& entering, const Squares& leaving, std::uint32_t* sums) noexcept {
  const auto slide = [](std::uint32_t* at, uint16x4_t in, uint16x4_t out) noexcept {
    vst1q_u32(at, vaddq_u32(vld1q_u32(at), vsubl_u16(in, out)));
  };
  slide(sums, vget_low_u16(entering.low), vget_low_u16(leaving.low));
  slide(sums + 4, vget_high_u16(entering.low), vget_high_u16(leaving.low));
  slide(sums + 8, vget_low_u16(entering.high), vget_low_u16(leaving.high));
  slide(sums + 12, vget_high_u16(entering.high), vget_high_u16(leaving.high));
}

constexpr auto kSquares = [](uint8x16_t a, uint8x16_t b) noexcept { return squares(a, b); };

}  // namespace

template <typename Sum>
void add_squares(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int lanes,
                 std::span<Sum> columns) noexcept {
  add_rows(left, right, lanes, columns, kSquares);
}

template <typename Sum>
void slide_squares(std::span<const std::uint8_t> new_left, std::span<const std::uint8_t> new_right,
                   std::span<const std::uint8_t> old_left, std::span<const std::uint8_t> old_right,
                   int lanes, std::span<Sum> columns) noexcept {
  slide_rows(new_left, new_right, old_left, old_right, lanes, columns, kSquares);
}

STOF_INSTANTIATE(AddDifferences, add_squares, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(SlideDifferences, slide_squares, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
