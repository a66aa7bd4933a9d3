#include "dsp/pmd/phase/phase.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kLanes = 16;

// What this variant is for: samples of 12 bits with limits of usual size, so that 16 bits with sign
// hold everything. Other rows are the NEON one's.
constexpr std::uint16_t kMostSample = 4095;
constexpr int kMostStray = 4096;
constexpr std::uint32_t kMostSlope = 4095;
constexpr std::int16_t kMostUneven = 255;
constexpr std::int16_t kQuarterQ15 = 1 << 13;

bool never_asymmetric(const PhaseLimits& limits) noexcept {
  return limits.asymmetry_base == 0xFFFFFFFF;
}

// Of limits; of the samples the loop tells afterwards.
bool fits(const PhaseLimits& limits) noexcept {
  const std::uint64_t noise =
      std::uint64_t{limits.asymmetry_base} + ((limits.asymmetry_slope_q8 * kMostSample) >> 8U);
  const bool noise_fits =
      limits.asymmetry_slope_q8 <= kMostSlope && noise < kMostUneven * kMostUneven;
  return limits.saturation >= 1 && limits.saturation <= kMostSample + 1 &&
         limits.lowest <= kMostSample + 1 && limits.min_amp2 <= 32767 &&
         limits.ratio_q16 <= 65535 &&
         std::max(std::abs(limits.stray_i), std::abs(limits.stray_q)) <= kMostStray &&
         (noise_fits || never_asymmetric(limits));
}

// Limits in every lane.
struct Limits {
  explicit Limits(const PhaseLimits& limits) noexcept
      : below_saturation(all(static_cast<std::int16_t>(limits.saturation - 1))),
        lowest(all(static_cast<std::int16_t>(limits.lowest))),
        min_amp2(all(static_cast<std::int16_t>(limits.min_amp2))),
        dark(all(limits.dark)),
        ratio(all(static_cast<std::uint16_t>(limits.ratio_q16))),
        stray_i(all(static_cast<std::uint16_t>(limits.stray_i))),
        stray_q(all(static_cast<std::uint16_t>(limits.stray_q))),
        asymmetry_base(all(static_cast<std::uint16_t>(limits.asymmetry_base))),
        asymmetry_slope(all(static_cast<std::uint16_t>(limits.asymmetry_slope_q8 << 4U))) {}

  i16x16 below_saturation;
  i16x16 lowest;
  i16x16 min_amp2;
  u16x16 dark;
  u16x16 ratio;
  u16x16 stray_i;
  u16x16 stray_q;
  u16x16 asymmetry_base;
  u16x16 asymmetry_slope;  // * 16
};

// The same bits: signed numbers compare and take signs, unsigned ones may wrap.
i16x16 with_sign(u16x16 v) noexcept { return std::bit_cast<i16x16>(v); }
u16x16 wrapping(i16x16 v) noexcept { return std::bit_cast<u16x16>(v); }

i16x16 absolute(i16x16 v) noexcept { return as<i16x16>(_mm256_abs_epi16(bits(v))); }

i16x16 above(i16x16 a, i16x16 b) noexcept {
  return as<i16x16>(_mm256_cmpgt_epi16(bits(a), bits(b)));
}

// (a b + 2^14) >> 15.
i16x16 scaled_product(i16x16 a, i16x16 b) noexcept {
  return as<i16x16>(_mm256_mulhrs_epi16(bits(a), bits(b)));
}

// (a b) >> 16.
u16x16 upper_product(u16x16 a, u16x16 b) noexcept {
  return as<u16x16>(_mm256_mulhi_epu16(bits(a), bits(b)));
}

// t in Q16, of which equal numbers have 65535; 0 / 0 is no number and becomes 0.
i32x8 ratio_q16(__m256i mn, __m256i mx) noexcept {
  // The lower halves of singles next to 128 count 2^-16: mx becomes 128 + mx / 65536.
  const __m256 small = _mm256_sub_ps(_mm256_castsi256_ps(mx), _mm256_set1_ps(128.0F));
  return as<i32x8>(_mm256_cvtps_epi32(_mm256_div_ps(_mm256_cvtepi32_ps(mn), small)));
}

u16x16 ratio_q16(i16x16 mn, i16x16 mx) noexcept {
  const __m256i none = _mm256_setzero_si256();
  const __m256i upper = _mm256_set1_epi16(0x4300);  // of 128.0F
  const i32x8 low =
      ratio_q16(_mm256_unpacklo_epi16(bits(mn), none), _mm256_unpacklo_epi16(bits(mx), upper));
  const i32x8 high =
      ratio_q16(_mm256_unpackhi_epi16(bits(mn), none), _mm256_unpackhi_epi16(bits(mx), upper));
  return as<u16x16>(_mm256_packus_epi32(bits(low), bits(high)));
}

u16x16 octant_angle(u16x16 t, i16x16 z) noexcept {
  i16x16 p = all(kArcTangentQ16.back());
  for (std::size_t k = kArcTangentQ16.size() - 1; k-- > 0;) {
    p = all(kArcTangentQ16[k]) + scaled_product(p, z);
  }
  // Not below 0: that is for t = 65534, which no two numbers of 13 bits have.
  const i16x16 bend = scaled_product(p, as<i16x16>(bits(t >> 1)));
  const __m256i sum = _mm256_adds_epu16(bits(t), bits(bend));
  return as<u16x16>(_mm256_avg_epu16(_mm256_srli_epi16(sum, 2), _mm256_setzero_si256()));
}

u16x16 fold_octants(u16x16 theta, i16x16 steep, i16x16 i, i16x16 q) noexcept {
  i16x16 angle = absolute(with_sign(theta) - (steep & std::int16_t{16384}));
  angle = absolute(angle ^ (i & std::int16_t{-32768}));  // left of the axis: angle - 32768
  return as<u16x16>(_mm256_sign_epi16(bits(angle), bits(q | std::int16_t{1})));
}

// (sqrt(1 + z) - 1) / z on 0 <= z <= 1, in Q16, lowest first: with it sqrt(I^2 + Q^2) is less than
// half a unit off for every I and Q up to 8191, tried one by one. Rounded down it is what is wanted
// or one less, and whole numbers tell which.
constexpr std::array<std::int16_t, 4> kRootQ16{32738, -7853, 2915, -653};

u16x16 magnitude(u16x16 mx, i16x16 z, u16x16 i, u16x16 q) noexcept {
  i16x16 p = all(kRootQ16.back());
  for (std::size_t k = kRootQ16.size() - 1; k-- > 0;) {
    p = all(kRootQ16[k]) + scaled_product(p, z);
  }
  const u16x16 root = mx + upper_product(mx, wrapping(scaled_product(p, z)));
  const u16x16 rest = i * i + q * q - root * root;  // within 16 bits and a sign
  return root - wrapping(above(with_sign(rest), with_sign(root)));
}

// uneven^2 > base + (slope * offset >> 8), where that is below 255^2.
i16x16 asymmetric(u16x16 uneven, u16x16 offset, const Limits& limits) noexcept {
  const u16x16 noise = limits.asymmetry_base + upper_product(offset << 4, limits.asymmetry_slope);
  const u16x16 inside = wrapping(smaller(absolute(with_sign(uneven)), all(kMostUneven)));
  return std::bit_cast<i16x16>(inside * inside > noise);
}

struct Samples {
  u16x16 a0;
  u16x16 a1;
  u16x16 a2;
  u16x16 a3;
};

// Masks are all ones where the flag is set.
struct Pixels {
  u16x16 phase;
  u16x16 amp2;
  u16x16 offset;
  i16x16 saturated;
  i16x16 under_range;
  i16x16 low_amplitude;
  i16x16 low_ratio;
  i16x16 asymmetric;
};

template <bool kStray>
u16x16 less_stray(u16x16 a, u16x16 b, u16x16 stray) noexcept {
  if constexpr (kStray) {
    return a - b - stray;
  } else {
    return a - b;
  }
}

template <bool kStray, bool kMayBeAsymmetric>
Pixels sixteen_pixels(const Samples& a, const Limits& limits, u16x16& most) noexcept {
  const u16x16 largest = larger(larger(a.a0, a.a2), larger(a.a1, a.a3));
  const u16x16 smallest = smaller(smaller(a.a0, a.a2), smaller(a.a1, a.a3));
  most |= largest;
  const u16x16 i = less_stray<kStray>(a.a0, a.a2, limits.stray_i);
  const u16x16 q = less_stray<kStray>(a.a3, a.a1, limits.stray_q);
  const i16x16 ai = absolute(with_sign(i));
  const i16x16 aq = absolute(with_sign(q));
  const i16x16 mx = larger(ai, aq);
  const u16x16 t = ratio_q16(smaller(ai, aq), mx);
  const i16x16 z = with_sign(upper_product(t, t) >> 1);
  const u16x16 even = a.a0 + a.a2;
  const u16x16 odd = a.a1 + a.a3;
  const u16x16 mean = wrapping(scaled_product(with_sign(even + odd), all(kQuarterQ15)));

  Pixels out{};
  out.phase = fold_octants(octant_angle(t, z), above(aq, ai), with_sign(i), with_sign(q));
  out.amp2 = magnitude(wrapping(mx), z, i, q);
  out.offset = as<u16x16>(_mm256_subs_epu16(bits(mean), bits(limits.dark)));
  const i16x16 amp2 = with_sign(out.amp2);
  out.saturated = above(with_sign(largest), limits.below_saturation);
  out.under_range = above(limits.lowest, with_sign(smallest));
  out.low_amplitude = above(limits.min_amp2, amp2);
  out.low_ratio = above(with_sign(upper_product(out.offset, limits.ratio)), amp2);
  if constexpr (kMayBeAsymmetric) {
    out.asymmetric = asymmetric(even - odd, out.offset, limits);
  }
  return out;
}

// Four times eight flags, of which the second and the third eight have changed places.
u8x32 flag(i16x16 low, i16x16 high, PmdFlag bit) noexcept {
  return as<u8x32>(_mm256_packs_epi16(bits(low), bits(high))) & static_cast<std::uint8_t>(bit);
}

template <bool kMayBeAsymmetric>
u8x32 flags_of(const Pixels& low, const Pixels& high) noexcept {
  const u8x32 asymmetric = kMayBeAsymmetric ? flag(low.asymmetric, high.asymmetric, kPmdAsymmetric)
                                            : all(std::uint8_t{0});
  const u8x32 flags = flag(low.saturated, high.saturated, kPmdSaturated) |
                      flag(low.under_range, high.under_range, kPmdUnderRange) |
                      flag(low.low_amplitude, high.low_amplitude, kPmdLowAmplitude) |
                      flag(low.low_ratio, high.low_ratio, kPmdLowRatio) | asymmetric;
  return as<u8x32>(_mm256_permute4x64_epi64(bits(flags), _MM_SHUFFLE(3, 1, 2, 0)));
}

// The first n pixels, n a multiple of kLanes; whether all samples were of 12 bits.
template <bool kStray, bool kMayBeAsymmetric>
bool whole_vectors(const SampleRows& samples, const PhaseLimits& limits, const PhaseRow& out,
                   std::size_t n) noexcept {
  const Limits lanes(limits);
  const std::array rows{samples[0].data(), samples[1].data(), samples[2].data(), samples[3].data()};
  const PhaseRow to = out;  // flags may not alias what is known of it
  u16x16 most = all(std::uint16_t{0});
  const auto sixteen = [&](std::size_t x) noexcept {
    return sixteen_pixels<kStray, kMayBeAsymmetric>(
        {load<u16x16>(rows[0] + x), load<u16x16>(rows[1] + x), load<u16x16>(rows[2] + x),
         load<u16x16>(rows[3] + x)},
        lanes, most);
  };
  const auto write = [&to](std::size_t x, const Pixels& pixels) noexcept {
    store(to.phase.data() + x, pixels.phase);
    store(to.amp2.data() + x, pixels.amp2);
    store(to.offset.data() + x, pixels.offset);
  };
  std::size_t x = 0;
  for (; x + 2 * kLanes <= n; x += 2 * kLanes) {
    const Pixels low = sixteen(x);
    const Pixels high = sixteen(x + kLanes);
    write(x, low);
    write(x + kLanes, high);
    store(to.flags.data() + x, flags_of<kMayBeAsymmetric>(low, high));
  }
  if (x != n) {
    const Pixels last = sixteen(x);
    write(x, last);
    store_half(to.flags.data() + x, flags_of<kMayBeAsymmetric>(last, last));
  }
  const u16x16 wide = most & static_cast<std::uint16_t>(~kMostSample);
  return _mm256_testz_si256(bits(wide), bits(wide)) != 0;
}

template <bool kStray>
bool whole_vectors(const SampleRows& samples, const PhaseLimits& limits, const PhaseRow& out,
                   std::size_t n) noexcept {
  return never_asymmetric(limits) ? whole_vectors<kStray, false>(samples, limits, out, n)
                                  : whole_vectors<kStray, true>(samples, limits, out, n);
}

}  // namespace

void phase(const SampleRows& samples, const PhaseLimits& limits, const PhaseRow& out) noexcept {
  const std::size_t n = out.phase.size();
  for (const std::span<const std::uint16_t>& row : samples) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(out.amp2.size() == n && out.offset.size() == n && out.flags.size() == n);
  STOF_CHECK(limits.ratio_q16 <= kMaxRatioQ16 && limits.asymmetry_slope_q8 <= kMaxAsymmetrySlopeQ8);
  const std::size_t whole = n - n % kLanes;
  const bool done = fits(limits) && (limits.stray_i == 0 && limits.stray_q == 0
                                         ? whole_vectors<false>(samples, limits, out, whole)
                                         : whole_vectors<true>(samples, limits, out, whole));
  const std::size_t x = done ? whole : 0;
  neon::phase(
      {samples[0].subspan(x), samples[1].subspan(x), samples[2].subspan(x), samples[3].subspan(x)},
      limits,
      {out.phase.subspan(x), out.amp2.subspan(x), out.offset.subspan(x), out.flags.subspan(x)});
}

}  // namespace stof::dsp::avx2
