#include "dsp/fusion/interval/column_interval.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 8;

// Numerator / difference for differences above `beyond`, where the quotient stays below max_range.
struct Division {
  std::int32_t beyond;  // differences up to here: max_range or more
  std::int32_t top;     // the numerator's first 31 bits: numerator = top 2^exponent, rounded down
  int exponent;
  std::uint32_t low;  // its last 32 bits

  Division(std::int64_t numerator, QuarterMm max_range) noexcept {
    constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
    beyond =
        static_cast<std::int32_t>(max_range == 0 ? kMost : std::min(numerator / max_range, kMost));
    exponent = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(numerator))) - 31;
    top = static_cast<std::int32_t>(numerator >> exponent);
    low = static_cast<std::uint32_t>(numerator & std::numeric_limits<std::uint32_t>::max());
  }
};

struct Quotient {
  uint32x4_t whole;
  uint32x4_t remainder;
};

// The exact quotient and remainder for 0 < difference < 2^31 and a quotient below 2^16.
// With x = difference 2^(leading - 31) in [1/2, 1), y near 1 / (2 x) as Q31: the line
// 24/17 - 16/17 x is off by at most a 17th, two steps of Newton square that twice, to 1.2e-5, from
// below; taking 2^-27 off outweighs what was rounded up. So the estimate is too small by less than
// 65536 * 1.3e-5 < 1: it is the quotient or one less, and the remainder says which.
Quotient divide(const Division& by, int32x4_t difference) noexcept {
  constexpr std::uint32_t kIntercept = 3031741621U;  // 24/17, Q31: wraps, the difference does not
  constexpr std::int32_t kSlope = 2021161080;        // 16/17
  const int32x4_t half = vdupq_n_s32(1 << 30);
  const int32x4_t leading = vsubq_s32(vclzq_s32(difference), vdupq_n_s32(1));
  const int32x4_t x = vshlq_s32(difference, leading);
  int32x4_t y = vreinterpretq_s32_u32(vsubq_u32(
      vdupq_n_u32(kIntercept), vreinterpretq_u32_s32(vqdmulhq_s32(x, vdupq_n_s32(kSlope)))));
  for (int step = 0; step < 2; ++step) {
    const int32x4_t missing = vsubq_s32(half, vqdmulhq_s32(x, y));  // 1/2 - x y
    y = vaddq_s32(y, vshlq_n_s32(vqdmulhq_s32(y, missing), 1));
  }
  y = vsubq_s32(y, vdupq_n_s32(16));
  const int32x4_t product = vqdmulhq_s32(y, vdupq_n_s32(by.top));
  const int32x4_t shift = vsubq_s32(vaddq_s32(leading, vdupq_n_s32(by.exponent)), vdupq_n_s32(30));
  uint32x4_t whole = vreinterpretq_u32_s32(vshlq_s32(product, shift));
  const uint32x4_t divisor = vreinterpretq_u32_s32(difference);
  uint32x4_t remainder = vmlsq_u32(vdupq_n_u32(by.low), whole, divisor);  // below 2 divisor < 2^32
  const uint32x4_t one_less = vcgeq_u32(remainder, divisor);
  whole = vsubq_u32(whole, one_less);
  remainder = vsubq_u32(remainder, vandq_u32(one_less, divisor));
  return {whole, remainder};
}

// Lanes at infinity are divided by something harmless and decided by a mask.
int32x4_t harmless(uint32x4_t beyond, int32x4_t difference) noexcept {
  return vbslq_s32(beyond, vdupq_n_s32(1 << 30), difference);
}

struct Ends {
  uint32x4_t low;
  uint32x4_t high;
};

Ends interval(const Division& near_by, const Division& far_by, std::uint32_t max_range,
              int32x4_t left, int32x4_t near_right, int32x4_t far_right) noexcept {
  const int32x4_t one = vdupq_n_s32(1);
  const int32x4_t near = vaddq_s32(vsubq_s32(near_right, left), one);
  const int32x4_t far = vsubq_s32(vsubq_s32(far_right, left), one);
  const uint32x4_t none = vcleq_s32(near, vdupq_n_s32(near_by.beyond));
  const uint32x4_t open = vcleq_s32(far, vdupq_n_s32(far_by.beyond));
  const Quotient low = divide(near_by, harmless(none, near));
  const Quotient high = divide(far_by, harmless(open, far));
  const uint32x4_t up = vtstq_u32(high.remainder, high.remainder);  // rounded up: + 1
  const uint32x4_t ceiling = vsubq_u32(high.whole, up);
  return {vbicq_u32(vmaxq_u32(low.whole, vdupq_n_u32(1)), none),
          vbicq_u32(vbslq_u32(open, vdupq_n_u32(max_range), ceiling), none)};
}

}  // namespace

void column_interval(std::span<const Disparity> disparity, std::span<const std::uint8_t> half,
                     const ColumnTables& tables, std::span<QuarterMm> low,
                     std::span<QuarterMm> high) noexcept {
  const std::size_t n = disparity.size();
  STOF_CHECK(tables.left.size() == n && half.size() == n && low.size() == n && high.size() == n);
  STOF_CHECK(tables.first_raw <= tables.last_raw);
  STOF_CHECK(tables.right.size() >= right_tangents(n, tables.first_raw, tables.last_raw));
  const Division near_by(tables.near_numerator, tables.max_range);
  const Division far_by(tables.far_numerator, tables.max_range);
  const int16x8_t first = vdupq_n_s16(tables.first_raw);
  const int16x8_t last = vdupq_n_s16(tables.last_raw);
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const int16x8_t raw = vld1q_s16(&disparity[x].raw);
    const uint16x8_t known =
        vbicq_u16(vandq_u16(vcgeq_s16(raw, first), vcleq_s16(raw, last)), vceqq_s16(raw, none));
    std::array<std::int32_t, kLanes> near{};
    std::array<std::int32_t, kLanes> far{};
    for (std::size_t k = 0; k < kLanes; ++k) {  // NEON has no gather
      const std::int16_t some = std::clamp(disparity[x + k].raw, tables.first_raw, tables.last_raw);
      const std::int32_t* const at = tables.right.data() + (x + k) * Disparity::kOne +
                                     (tables.last_raw - some) + kMostHalfWidth;
      near[k] = at[-std::ptrdiff_t{half[x + k]}];
      far[k] = at[half[x + k]];
    }
    const std::int32_t* const left = tables.left.data() + x;
    const Ends a = interval(near_by, far_by, tables.max_range, vld1q_s32(left),
                            vld1q_s32(near.data()), vld1q_s32(far.data()));
    const Ends b = interval(near_by, far_by, tables.max_range, vld1q_s32(left + 4),
                            vld1q_s32(near.data() + 4), vld1q_s32(far.data() + 4));
    vst1q_u16(low.data() + x, vandq_u16(known, vcombine_u16(vmovn_u32(a.low), vmovn_u32(b.low))));
    vst1q_u16(high.data() + x,
              vandq_u16(known, vcombine_u16(vmovn_u32(a.high), vmovn_u32(b.high))));
  }
  if (x < n) {
    ColumnTables rest = tables;
    rest.left = tables.left.subspan(x);
    rest.right = tables.right.subspan(x * Disparity::kOne);
    ref::column_interval(disparity.subspan(x), half.subspan(x), rest, low.subspan(x),
                         high.subspan(x));
  }
}

}  // namespace stof::dsp::neon
