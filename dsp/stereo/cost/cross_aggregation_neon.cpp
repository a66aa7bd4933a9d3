#include "dsp/stereo/cost/cross_aggregation.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kStep = 8;

// Eight means that are not clipped yet; reciprocal is not negative, so nothing saturates.
int16x8_t mean(const std::uint16_t* above, const std::uint16_t* below,
               int16x8_t reciprocal) noexcept {
  const uint16x8_t sum = vsubq_u16(vld1q_u16(below), vld1q_u16(above));
  return simd::scaled_product(vreinterpretq_s16_u16(vshrq_n_u16(sum, 1)), reciprocal);
}

}  // namespace

void sum_along(std::span<const std::uint8_t> costs, int lanes,
               std::span<std::uint16_t> sums) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && sums.size() == costs.size() + step);
  for (std::size_t i = 0; i < step; i += kStep) {
    vst1q_u16(sums.data() + i, vdupq_n_u16(0));
  }
  // Groups of 32 candidates stay in registers all along the row.
  std::size_t group = 0;
  for (; group + 32 <= step; group += 32) {
    uint16x8_t a = vdupq_n_u16(0);
    uint16x8_t b = a;
    uint16x8_t c = a;
    uint16x8_t d = a;
    for (std::size_t i = group; i < costs.size(); i += step) {
      const uint8x16_t low = vld1q_u8(costs.data() + i);
      const uint8x16_t high = vld1q_u8(costs.data() + i + 16);
      a = vaddw_u8(a, vget_low_u8(low));
      b = vaddw_u8(b, vget_high_u8(low));
      c = vaddw_u8(c, vget_low_u8(high));
      d = vaddw_u8(d, vget_high_u8(high));
      std::uint16_t* const to = sums.data() + i + step;
      vst1q_u16(to, a);
      vst1q_u16(to + 8, b);
      vst1q_u16(to + 16, c);
      vst1q_u16(to + 24, d);
    }
  }
  for (; group < step; group += kStep) {
    uint16x8_t a = vdupq_n_u16(0);
    for (std::size_t i = group; i < costs.size(); i += step) {
      a = vaddw_u8(a, vld1_u8(costs.data() + i));
      vst1q_u16(sums.data() + i + step, a);
    }
  }
}

void sum_down(std::span<const std::uint16_t> sums, std::span<const std::uint8_t> left,
              std::span<const std::uint8_t> right, int lanes, std::span<const std::uint16_t> above,
              std::span<std::uint16_t> below) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && right.size() == left.size() &&
             sums.size() == (left.size() + 1) * step && above.size() == left.size() * step &&
             below.size() == above.size());
  for (std::size_t x = 0; x < left.size(); ++x) {
    const std::uint16_t* const begin = sums.data() + (x - left[x]) * step;
    const std::uint16_t* const end = sums.data() + (x + right[x] + 1) * step;
    const std::uint16_t* const from = above.data() + x * step;
    std::uint16_t* const to = below.data() + x * step;
    for (std::size_t i = 0; i < step; i += kStep) {
      const uint16x8_t row = vsubq_u16(vld1q_u16(end + i), vld1q_u16(begin + i));
      vst1q_u16(to + i, vaddq_u16(vld1q_u16(from + i), row));
    }
  }
}

void cross_means(std::span<const CrossEnds> ends, int lanes,
                 std::span<std::uint8_t> means) noexcept {
  const auto step = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes % 16 == 0 && means.size() == ends.size() * step);
  for (std::size_t x = 0; x < ends.size(); ++x) {
    const std::uint16_t* const above = ends[x].above + x * step;
    const std::uint16_t* const below = ends[x].below + x * step;
    const int16x8_t reciprocal = vdupq_n_s16(ends[x].reciprocal);
    std::uint8_t* const to = means.data() + x * step;
    for (std::size_t i = 0; i < step; i += 2 * kStep) {
      const int16x8_t low = mean(above + i, below + i, reciprocal);
      const int16x8_t high = mean(above + i + kStep, below + i + kStep, reciprocal);
      vst1q_u8(to + i, vcombine_u8(vqmovun_s16(low), vqmovun_s16(high)));
    }
  }
}

}  // namespace stof::dsp::neon
