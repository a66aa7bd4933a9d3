#include "dsp/pmd/interval/average_pairs.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

// Of eight readings.
struct Sums {
  uint16x8_t pairs = vdupq_n_u16(0);
  int16x8_t pull = vdupq_n_s16(0);
  uint16x8_t noises = vdupq_n_u16(0);
};

struct Readings {
  uint16x8_t distance;
  uint16x8_t sigma;
};

// The reading itself, and how far a slope may go.
struct Here {
  Readings reading;
  uint16x8_t there;
  uint16x8_t slope;
};

uint16x8_t high_halves(uint16x8_t v, std::uint16_t factor) noexcept {
  return vcombine_u16(vshrn_n_u32(vmull_n_u16(vget_low_u16(v), factor), 16),
                      vshrn_n_u32(vmull_n_u16(vget_high_u16(v), factor), 16));
}

Here look(const Readings& reading, std::uint16_t slope_q16) noexcept {
  const uint16x8_t quiet = vcleq_u16(reading.sigma, vdupq_n_u16(kMaxAveragedSigma));
  return {reading, vandq_u16(vtstq_u16(reading.distance, reading.distance), quiet),
          high_halves(reading.distance, slope_q16)};
}

void add_pair(const Here& here, const Readings& a, const Readings& b, Sums& sums) noexcept {
  const uint16x8_t d = here.reading.distance;
  const uint16x8_t s = here.reading.sigma;
  const uint16x8_t mean = vrhaddq_u16(a.distance, b.distance);
  const uint16x8_t noise = vrhaddq_u16(a.sigma, b.sigma);
  const uint16x8_t twice = vqaddq_u16(noise, noise);
  const uint16x8_t reach = vminq_u16(vqaddq_u16(vqaddq_u16(s, s), noise), vdupq_n_u16(kMaxPull));
  const uint16x8_t step = vqaddq_u16(vqaddq_u16(vqaddq_u16(twice, twice), twice), here.slope);
  const uint16x8_t nearest = vminq_u16(a.distance, b.distance);
  uint16x8_t counts = vandq_u16(here.there, vtstq_u16(nearest, nearest));
  counts =
      vandq_u16(counts, vcleq_u16(vmaxq_u16(a.sigma, b.sigma), vdupq_n_u16(kMaxAveragedSigma)));
  counts = vandq_u16(counts, vcleq_u16(vabdq_u16(mean, d), reach));
  counts = vandq_u16(counts, vcleq_u16(vabdq_u16(a.distance, b.distance), step));
  sums.pairs = vsubq_u16(sums.pairs, counts);
  sums.pull = vaddq_s16(sums.pull, vreinterpretq_s16_u16(vandq_u16(vsubq_u16(mean, d), counts)));
  sums.noises = vaddq_u16(sums.noises, vandq_u16(noise, counts));
}

// An element of a table of u16 for each number of pairs.
uint16x8_t share_of(uint16x8_t pairs, const std::array<std::uint16_t, 5>& shares) noexcept {
  std::array<std::uint16_t, 8> table{};
  for (std::size_t p = 0; p < shares.size(); ++p) {
    table[p] = shares[p];
  }
  // The bytes of element p lie at 2 p and 2 p + 1.
  const uint16x8_t places = vaddq_u16(vmulq_n_u16(pairs, 0x0202), vdupq_n_u16(0x0100));
  return vreinterpretq_u16_u8(
      vqtbl1q_u8(vreinterpretq_u8_u16(vld1q_u16(table.data())), vreinterpretq_u8_u16(places)));
}

void finish(const Here& here, const Sums& sums, QuarterMm* out_distance,
            QuarterMm* out_sigma) noexcept {
  const uint16x8_t d = here.reading.distance;
  const uint16x8_t s = here.reading.sigma;
  const uint16x8_t share = share_of(sums.pairs, kPairShare);
  const int16x8_t part = vreinterpretq_s16_u16(share);
  const int16x8_t pull =
      vcombine_s16(vrshrn_n_s32(vmull_s16(vget_low_s16(sums.pull), vget_low_s16(part)), 15),
                   vrshrn_n_s32(vmull_s16(vget_high_s16(sums.pull), vget_high_s16(part)), 15));
  const uint16x8_t sum = vaddq_u16(s, vaddq_u16(sums.noises, sums.noises));
  const uint16x8_t mean =
      vcombine_u16(vrshrn_n_u32(vmull_u16(vget_low_u16(sum), vget_low_u16(share)), 16),
                   vrshrn_n_u32(vmull_u16(vget_high_u16(sum), vget_high_u16(share)), 16));
  const uint16x8_t less = share_of(sums.pairs, kSmoothShare);
  const uint16x8_t sigma =
      vcombine_u16(vrshrn_n_u32(vmull_u16(vget_low_u16(mean), vget_low_u16(less)), 15),
                   vrshrn_n_u32(vmull_u16(vget_high_u16(mean), vget_high_u16(less)), 15));
  const uint16x8_t smoothed = vmaxq_u16(vminq_u16(s, sigma), vdupq_n_u16(1));
  const uint16x8_t alone = vceqq_u16(sums.pairs, vdupq_n_u16(0));
  const uint16x8_t there = vtstq_u16(d, d);
  vst1q_u16(out_distance, vaddq_u16(d, vreinterpretq_u16_s16(pull)));
  vst1q_u16(out_sigma, vandq_u16(vbslq_u16(alone, s, smoothed), there));
}

}  // namespace

void average_pairs(const IntervalRows& rows, std::uint16_t slope_q16,
                   std::span<QuarterMm> out_distance, std::span<QuarterMm> out_sigma) noexcept {
  const std::size_t n = out_distance.size();
  STOF_CHECK(out_sigma.size() == n);
  STOF_CHECK(rows.distance_above.size() == n + 2 && rows.sigma_above.size() == n + 2);
  STOF_CHECK(rows.distance_here.size() == n + 2 && rows.sigma_here.size() == n + 2);
  STOF_CHECK(rows.distance_below.size() == n + 2 && rows.sigma_below.size() == n + 2);
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    const auto above = [&](std::size_t k) noexcept {
      return Readings{vld1q_u16(rows.distance_above.data() + x + k),
                      vld1q_u16(rows.sigma_above.data() + x + k)};
    };
    const auto beside = [&](std::size_t k) noexcept {
      return Readings{vld1q_u16(rows.distance_here.data() + x + k),
                      vld1q_u16(rows.sigma_here.data() + x + k)};
    };
    const auto below = [&](std::size_t k) noexcept {
      return Readings{vld1q_u16(rows.distance_below.data() + x + k),
                      vld1q_u16(rows.sigma_below.data() + x + k)};
    };
    const Here here = look(beside(1), slope_q16);
    Sums sums;
    add_pair(here, above(0), below(2), sums);
    add_pair(here, above(1), below(1), sums);
    add_pair(here, above(2), below(0), sums);
    add_pair(here, beside(0), beside(2), sums);
    finish(here, sums, out_distance.data() + x, out_sigma.data() + x);
  }
  ref::average_pairs(behind(rows, x), slope_q16, out_distance.subspan(x), out_sigma.subspan(x));
}

}  // namespace stof::dsp::neon
