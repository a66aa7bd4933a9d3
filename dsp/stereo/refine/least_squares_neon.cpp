#include "dsp/stereo/refine/least_squares.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

struct Sums {
  int32x4_t moment;
  int32x4_t energy;
};

// Eight columns of one row of the block; lanes outside `inside` do not count.
void accumulate(const std::uint8_t* g, const std::uint8_t* f, int16x8_t inside,
                Sums& sums) noexcept {
  const int16x8_t derivative =
      vandq_s16(vreinterpretq_s16_u16(vsubl_u8(vld1_u8(g + 1), vld1_u8(g - 1))), inside);
  const int16x8_t difference = vreinterpretq_s16_u16(vsubl_u8(vld1_u8(f), vld1_u8(g)));
  const int16x4_t low = vget_low_s16(derivative);
  const int16x4_t high = vget_high_s16(derivative);
  sums.moment = vmlal_s16(sums.moment, low, vget_low_s16(difference));
  sums.moment = vmlal_s16(sums.moment, high, vget_high_s16(difference));
  sums.energy = vmlal_s16(sums.energy, low, low);
  sums.energy = vmlal_s16(sums.energy, high, high);
}

// All ones for the first `count` of eight lanes.
int16x8_t first(int count) noexcept {
  constexpr std::array<std::int16_t, 8> kIndex{0, 1, 2, 3, 4, 5, 6, 7};
  return vreinterpretq_s16_u16(
      vcltq_s16(vld1q_s16(kIndex.data()), vdupq_n_s16(static_cast<std::int16_t>(count))));
}

// One pixel whose vectors stay inside both rows.
Disparity refine_inside(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                        int begin, int y, int block_width, int block_height, int whole) noexcept {
  Sums sums{vdupq_n_s32(0), vdupq_n_s32(0)};
  const int16x8_t all = first(8);
  const int full = block_width / 8 * 8;
  const int16x8_t rest = first(block_width - full);
  for (int row = y - block_height / 2; row < y - block_height / 2 + block_height; ++row) {
    const std::uint8_t* const g = left.row_clamped(row).data() + begin;
    const std::uint8_t* const f = right.row_clamped(row).data() + (begin - whole);
    int k = 0;
    for (; k < full; k += 8) {
      accumulate(g + k, f + k, all, sums);
    }
    if (k < block_width) {
      accumulate(g + k, f + k, rest, sums);
    }
  }
  return shifted_disparity(whole, vaddvq_s32(sums.moment), vaddvq_s32(sums.energy));
}

}  // namespace

void refine_least_squares(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                          int y, int block_width, int block_height,
                          std::span<Disparity> disparities) noexcept {
  STOF_CHECK(same_size(left, right) && y >= 0 && y < left.height() && block_width >= 1 &&
             block_width <= 64 && block_height >= 1 && block_height <= 64 &&
             disparities.size() == static_cast<std::size_t>(left.width()));
  constexpr std::size_t kTogether = 8;
  std::array<std::int16_t, kTogether> raw{};
  const int vectors = (block_width + 7) / 8 * 8;
  for (int x = 0; x < left.width(); ++x) {
    const std::size_t at = static_cast<std::size_t>(x);
    const Disparity disparity = disparities[at];
    const int whole = round_shift<int>(disparity.raw, Disparity::kFractionBits);
    const int begin = x - block_width / 2;
    const bool inside = disparity.valid() && begin >= 1 && begin + vectors < left.width() &&
                        begin - whole >= 0 && begin - whole + vectors <= left.width();
    const Disparity refined =
        inside ? refine_inside(left, right, begin, y, block_width, block_height, whole)
               : least_squares_at(left, right, x, y, block_width, block_height, disparity);
    raw[at % kTogether] = refined.raw;
    if (at % kTogether == kTogether - 1) {
      vst1q_s16(&disparities[at - (kTogether - 1)].raw, vld1q_s16(raw.data()));
    } else if (x + 1 == left.width()) {
      for (std::size_t k = 0; k <= at % kTogether; ++k) {
        disparities[at - at % kTogether + k].raw = raw[k];
      }
    }
  }
}

}  // namespace stof::dsp::neon
