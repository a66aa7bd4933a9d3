#include "dsp/pmd/range/combine_frequencies.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::neon {
namespace {

constexpr int kLanes = 8;

// In every lane.
struct Lanes {
  int32x4_t m;
  uint32x4_t inverse;
  uint32x4_t per_m;  // 2^24 / m rounded up: x / m is (x per_m) >> 24 for x < m^2 <= 2^16
  int32x4_t range;
  int32x4_t tolerance;
  uint32x4_t max_variance;
  float32x4_t m_real;
  float32x4_t n_real;
  float32x4_t share;
};

Lanes lanes_of(const FrequencyPair& pair) noexcept {
  constexpr std::uint32_t kOne = 1U << 24U;
  return {.m = vdupq_n_s32(static_cast<int>(pair.m)),
          .inverse = vdupq_n_u32(pair.inverse),
          .per_m = vdupq_n_u32((kOne + pair.m - 1) / pair.m),
          .range = vdupq_n_s32(static_cast<int>(pair.m << 20U)),
          .tolerance = vdupq_n_s32(static_cast<int>(pair.tolerance)),
          .max_variance = vdupq_n_u32(pair.max_variance),
          .m_real = vdupq_n_f32(static_cast<float>(pair.m)),
          .n_real = vdupq_n_f32(static_cast<float>(pair.n)),
          .share = vdupq_n_f32(16.0F / static_cast<float>(pair.n))};
}

// (q inverse) mod m for -m < q <= m.
uint32x4_t turns_of(int32x4_t q, const Lanes& lanes) noexcept {
  const uint32x4_t below = vcltq_s32(q, vdupq_n_s32(0));
  q = vaddq_s32(q, vandq_s32(vreinterpretq_s32_u32(below), lanes.m));
  q = vbicq_s32(q, vreinterpretq_s32_u32(vceqq_s32(q, lanes.m)));
  const uint32x4_t x = vmulq_u32(vreinterpretq_u32_s32(q), lanes.inverse);
  const uint32x4_t whole = vshrq_n_u32(vmulq_u32(x, lanes.per_m), 24);
  return vsubq_u32(x, vmulq_u32(whole, vreinterpretq_u32_s32(lanes.m)));
}

int32x4_t correction(uint16x4_t amp2, uint16x4_t other, int32x4_t rest,
                     const Lanes& lanes) noexcept {
  const float32x4_t near = vmulq_f32(lanes.m_real, vcvtq_f32_u32(vmovl_u16(amp2)));
  const float32x4_t far = vmulq_f32(lanes.n_real, vcvtq_f32_u32(vmovl_u16(other)));
  const float32x4_t near_power = vmulq_f32(near, near);
  const float32x4_t far_power = vmulq_f32(far, far);
  const float32x4_t both = vmaxq_f32(vaddq_f32(near_power, far_power), vdupq_n_f32(1.0F));
  const float32x4_t weight = vmulq_f32(simd::divide(far_power, both), lanes.share);
  const float32x4_t magic = vdupq_n_f32(12582912.0F);  // simd::round_to_int takes no negative ones
  const float32x4_t rounded = vaddq_f32(vmulq_f32(weight, vcvtq_f32_s32(rest)), magic);
  return vsubq_s32(vreinterpretq_s32_f32(rounded), vreinterpretq_s32_f32(magic));
}

// Into 0 .. range - 1; nothing is further outside than one range.
int32x4_t wrapped_way(int32x4_t way, const Lanes& lanes) noexcept {
  const uint32x4_t below = vcltq_s32(way, vdupq_n_s32(0));
  way = vaddq_s32(way, vandq_s32(vreinterpretq_s32_u32(below), lanes.range));
  const uint32x4_t above = vcgeq_s32(way, lanes.range);
  return vsubq_s32(way, vandq_s32(vreinterpretq_s32_u32(above), lanes.range));
}

struct Half {
  uint32x4_t distance;
  uint32x4_t wrapped;
};

Half combine(uint16x4_t phi1, uint16x4_t phi2, uint16x4_t amp2, uint16x4_t other,
             const FrequencyPair& pair, const Lanes& lanes) noexcept {
  const int32x4_t up =
      vreinterpretq_s32_u32(vmull_u16(phi2, vdup_n_u16(static_cast<std::uint16_t>(pair.m))));
  const int32x4_t down =
      vreinterpretq_s32_u32(vmull_u16(phi1, vdup_n_u16(static_cast<std::uint16_t>(pair.n))));
  const int32x4_t beat = vsubq_s32(up, down);
  const int32x4_t q = vrshrq_n_s32(beat, 16);
  const int32x4_t rest = vsubq_s32(beat, vshlq_n_s32(q, 16));
  const uint32x4_t units = vorrq_u32(vshlq_n_u32(turns_of(q, lanes), 16), vmovl_u16(phi1));
  const int32x4_t way =
      vaddq_s32(vreinterpretq_s32_u32(vshlq_n_u32(units, 4)), correction(amp2, other, rest, lanes));
  const uint32x4_t whole = vreinterpretq_u32_s32(wrapped_way(way, lanes));
  const uint32x2_t turn = vdup_n_u32(pair.turn_q11);
  const uint32x4_t tenths = vcombine_u32(vrshrn_n_u64(vmull_u32(vget_low_u32(whole), turn), 31),
                                         vrshrn_n_u64(vmull_u32(vget_high_u32(whole), turn), 31));
  return {vmaxq_u32(tenths, vdupq_n_u32(1)), vcgtq_s32(vabsq_s32(rest), lanes.tolerance)};
}

uint32x4_t noisy(uint16x4_t sigma, uint16x4_t other, const Lanes& lanes) noexcept {
  const uint32x4_t sum = vqaddq_u32(vmull_u16(sigma, sigma), vmull_u16(other, other));
  return vcgtq_u32(sum, lanes.max_variance);
}

uint16x8_t noisy(const FrequencyReadings& first, const FrequencyReadings& second, std::size_t x,
                 const Lanes& lanes) noexcept {
  if (first.sigma.empty()) {
    return vdupq_n_u16(0);
  }
  const uint16x8_t sigma = vld1q_u16(first.sigma.data() + x);
  const uint16x8_t other = vld1q_u16(second.sigma.data() + x);
  return vcombine_u16(vmovn_u32(noisy(vget_low_u16(sigma), vget_low_u16(other), lanes)),
                      vmovn_u32(noisy(vget_high_u16(sigma), vget_high_u16(other), lanes)));
}

FrequencyReadings from(const FrequencyReadings& frequency, std::size_t x) noexcept {
  return {frequency.phase.subspan(x), frequency.amp2.subspan(x),
          frequency.sigma.empty() ? frequency.sigma : frequency.sigma.subspan(x)};
}

}  // namespace

void combine_frequencies(const FrequencyReadings& first, const FrequencyReadings& second,
                         const FrequencyPair& pair, std::span<const std::uint8_t> other_flags,
                         std::span<std::uint8_t> flags,
                         std::span<std::uint32_t> distance) noexcept {
  const std::size_t count = distance.size();
  check_combine_frequencies(first, second, pair, count);
  STOF_CHECK(other_flags.size() == count && flags.size() == count);
  const Lanes lanes = lanes_of(pair);
  const uint16x8_t missing_bits = vdupq_n_u16(kPmdMissing);
  std::size_t x = 0;
  for (; x + kLanes <= count; x += kLanes) {
    const uint16x8_t phi1 = vld1q_u16(first.phase.data() + x);
    const uint16x8_t phi2 = vld1q_u16(second.phase.data() + x);
    const uint16x8_t amp2 = vld1q_u16(first.amp2.data() + x);
    const uint16x8_t other = vld1q_u16(second.amp2.data() + x);
    const Half low = combine(vget_low_u16(phi1), vget_low_u16(phi2), vget_low_u16(amp2),
                             vget_low_u16(other), pair, lanes);
    const Half high = combine(vget_high_u16(phi1), vget_high_u16(phi2), vget_high_u16(amp2),
                              vget_high_u16(other), pair, lanes);
    const uint16x8_t wrapped =
        vorrq_u16(vcombine_u16(vmovn_u32(low.wrapped), vmovn_u32(high.wrapped)),
                  noisy(first, second, x, lanes));
    const uint16x8_t before =
        vmovl_u8(vorr_u8(vld1_u8(flags.data() + x), vld1_u8(other_flags.data() + x)));
    const uint16x8_t flag = vorrq_u16(before, vandq_u16(wrapped, vdupq_n_u16(kPmdWrapped)));
    const int16x8_t missing = vreinterpretq_s16_u16(vtstq_u16(flag, missing_bits));
    vst1_u8(flags.data() + x, vmovn_u16(flag));
    vst1q_u32(distance.data() + x,
              vbicq_u32(low.distance, vreinterpretq_u32_s32(vmovl_s16(vget_low_s16(missing)))));
    vst1q_u32(distance.data() + x + 4,
              vbicq_u32(high.distance, vreinterpretq_u32_s32(vmovl_s16(vget_high_s16(missing)))));
  }
  ref::combine_frequencies(from(first, x), from(second, x), pair, other_flags.subspan(x),
                           flags.subspan(x), distance.subspan(x));
}

}  // namespace stof::dsp::neon
