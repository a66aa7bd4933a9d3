#include "dsp/pmd/phase/phase.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp::ref {
namespace {

constexpr int kQuarterTurn = 16384;
constexpr int kHalfTurn = 32768;
constexpr int kLargest = 32767;  // of a sample, of I and Q

// Nearest integer to `v`, ties to even, for 0 <= v < 2^22.
int nearest_even(float v) noexcept { return static_cast<int>(v + 12582912.0F) - 12582912; }

// Rounded (a * b) >> 15.
int multiply_q15(int a, int b) noexcept { return round_shift(a * b, kQ15Bits); }

// atan(mn / mx) in phase units, 0 .. 8192; 0 <= mn <= mx.
int octant_angle(int mn, int mx) noexcept {
  const float ratio = static_cast<float>(mn) / static_cast<float>(std::max(mx, 1));
  const int t = std::min(nearest_even(ratio * 65536.0F), 65535);
  const int z =
      static_cast<int>((static_cast<std::uint32_t>(t) * static_cast<std::uint32_t>(t)) >> 17U);
  int p = kArcTangentQ16.back();
  for (std::size_t k = kArcTangentQ16.size() - 1; k-- > 0;) {
    p = kArcTangentQ16[k] + multiply_q15(p, z);
  }
  const int u = std::min(t + std::max(multiply_q15(p, t >> 1), 0), 65535);
  return round_shift(u, 3);
}

Phase phase_of(int i, int q) noexcept {
  const int ai = std::abs(i);
  const int aq = std::abs(q);
  int theta = octant_angle(std::min(ai, aq), std::max(ai, aq));
  theta = aq > ai ? kQuarterTurn - theta : theta;
  theta = i < 0 ? kHalfTurn - theta : theta;
  return static_cast<Phase>(q < 0 ? -theta : theta);
}

// sqrt(n) rounded to nearest; no n lies halfway. n < 2^31.
std::uint32_t rounded_root(std::uint32_t n) noexcept {
  std::uint32_t root = 0;
  for (std::uint32_t bit = 1U << 15U; bit != 0; bit >>= 1U) {
    const std::uint32_t larger = root | bit;
    root = larger * larger <= n ? larger : root;
  }
  return n > root * root + root ? root + 1 : root;
}

// I or Q without stray light.
int less_stray(int difference, int stray) noexcept {
  return std::clamp(difference - stray, -kLargest, kLargest);
}

unsigned flag_if(bool condition, PmdFlag flag) noexcept { return condition ? unsigned{flag} : 0; }

}  // namespace

void phase(const SampleRows& samples, const PhaseLimits& limits, const PhaseRow& out) noexcept {
  const std::size_t n = out.phase.size();
  for (const std::span<const std::uint16_t>& row : samples) {
    STOF_CHECK(row.size() == n);
  }
  STOF_CHECK(out.amp2.size() == n && out.offset.size() == n && out.flags.size() == n);
  STOF_CHECK(limits.ratio_q16 <= kMaxRatioQ16 && limits.asymmetry_slope_q8 <= kMaxAsymmetrySlopeQ8);
  for (std::size_t x = 0; x < n; ++x) {
    std::array<int, 4> a{};
    unsigned flag = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      const std::uint16_t sample = samples[k][x];
      flag |= flag_if(sample >= limits.saturation, kPmdSaturated);
      flag |= flag_if(sample < limits.lowest, kPmdUnderRange);
      a[k] = std::min<int>(sample, kLargest);
    }
    const int i = less_stray(a[0] - a[2], limits.stray_i);
    const int q = less_stray(a[3] - a[1], limits.stray_q);
    const std::uint32_t magnitude = rounded_root(static_cast<std::uint32_t>(i * i + q * q));
    const int mean = (a[0] + a[1] + a[2] + a[3] + 2) / 4;
    const std::uint32_t light = static_cast<std::uint32_t>(std::max(mean - limits.dark, 0));
    const std::uint32_t uneven = static_cast<std::uint32_t>(std::abs(a[0] + a[2] - a[1] - a[3]));
    flag |= flag_if(magnitude < limits.min_amp2, kPmdLowAmplitude);
    flag |= flag_if(magnitude < (limits.ratio_q16 * light) >> 16U, kPmdLowRatio);
    const std::uint64_t noise =
        std::uint64_t{limits.asymmetry_base} + ((limits.asymmetry_slope_q8 * light) >> 8U);
    flag |= flag_if(uneven * uneven > std::min<std::uint64_t>(noise, 0xFFFFFFFF), kPmdAsymmetric);
    out.phase[x] = phase_of(i, q);
    out.amp2[x] = static_cast<std::uint16_t>(magnitude);
    out.offset[x] = static_cast<std::uint16_t>(light);
    out.flags[x] = static_cast<std::uint8_t>(flag);
  }
}

}  // namespace stof::dsp::ref
