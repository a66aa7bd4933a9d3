#include "firmware/loop/light_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stof::firmware {
namespace {

constexpr int kWatchedRows = 36;  // and less than twice as many
constexpr int kPixelsForEachStray = 256;
constexpr int kPixelsForEachReturned = 128;
constexpr int kVariances = 40;
constexpr int kSamples = 4;
constexpr int kQ16 = 16;
constexpr int kQ8 = 8;
// Of twice the amplitude, in units of the sum of four samples times 2^-8.
constexpr int kSquareBits = 2 * (kQ8 + 2);
// The even sums have 4 variances. Their square is below 0.455 times that in half of the pixels;
// with 1.5 times the variance that is 40 / 15 of one.
constexpr int kMedianShare = 15;

// By how much noise may exceed the calibration's: 4^level in variance.
constexpr std::size_t kLevels = 5;
using Counts = std::array<int, kLevels>;

// 40 times a variance. Limited so that it can be computed with, whatever a calibration says.
std::int64_t threshold_q16(double variance) noexcept {
  constexpr double kOne = 1 << kQ16;
  constexpr double kLimit = 1e13;
  return std::llround(std::clamp(kVariances * kOne * variance, -kLimit, kLimit));
}

int whole_lsb(double value) noexcept {
  constexpr double kLimit = 65535;
  return static_cast<int>(std::lround(std::clamp(value, -kLimit, kLimit)));
}

std::int64_t square_sum(std::int64_t a, std::int64_t b) noexcept { return a * a + b * b; }

}  // namespace

LightGuard::LightGuard(const dsp::PmdSensor& sensor) noexcept
    : least_square_(4 * std::int64_t{sensor.min_amplitude_lsb} * sensor.min_amplitude_lsb),
      noise_q16_(
          threshold_q16(sensor.noise_lsb * sensor.noise_lsb +
                        (sensor.suppressed_lsb - sensor.dark_lsb) / sensor.electrons_per_lsb)),
      shot_q16_(threshold_q16(1 / (kSamples * sensor.electrons_per_lsb))),
      four_dark_(4 * whole_lsb(sensor.dark_lsb)),
      ratio_q8_(static_cast<int>(
          std::lround(std::clamp(sensor.frequency.min_modulation_ratio, 0.0, 1.0) * (1 << kQ8)))),
      stray_i_(whole_lsb(sensor.frequency.stray_i_lsb)),
      stray_q_(whole_lsb(sensor.frequency.stray_q_lsb)) {}

bool LightGuard::is_lit(const hal::PmdFrame& frame) noexcept {
  const auto [lit, all] = count(frame);
  was_lit_ = lit * (was_lit_ ? kPixelsForEachStray : kPixelsForEachReturned) > all;
  return was_lit_;
}

LightGuard::Count LightGuard::count(const hal::PmdFrame& frame) const noexcept {
  Counts lit{};
  Counts spread{};  // even sums above what this level explains in half of the pixels
  int all = 0;
  const int height = frame.samples[0].height();
  for (int y = 0; y < height; y += std::max(height / kWatchedRows, 1)) {
    const auto a0 = frame.samples[0].row(y);
    const auto a1 = frame.samples[1].row(y);
    const auto a2 = frame.samples[2].row(y);
    const auto a3 = frame.samples[3].row(y);
    for (std::size_t x = 0; x < a0.size(); ++x) {
      const int in_phase = int{a0[x]} - int{a2[x]};
      const int quadrature = int{a3[x]} - int{a1[x]};
      const std::int64_t even = int{a0[x]} + int{a2[x]};
      const std::int64_t odd = int{a1[x]} + int{a3[x]};
      const std::int64_t square = std::min(square_sum(in_phase, quadrature),
                                           square_sum(in_phase - stray_i_, quadrature - stray_q_));
      const std::int64_t light = (even + odd - four_dark_) * ratio_q8_;
      const bool drowned = square << kSquareBits < light * light;
      const std::int64_t uneven = (even - odd) * (even - odd) * kMedianShare;
      std::int64_t noise =
          std::max((noise_q16_ + shot_q16_ * (even + odd)) >> kQ16, std::int64_t{1});
      for (std::size_t level = 0; level < kLevels; ++level, noise *= 4) {
        lit[level] += !drowned && square > std::max(least_square_, noise) ? 1 : 0;
        spread[level] += uneven > noise ? 1 : 0;
      }
    }
    all += static_cast<int>(a0.size());
  }
  const auto level = std::ranges::find_if(spread.begin(), spread.end() - 1,
                                          [all](int wide) { return 2 * wide <= all; });
  return {.lit = lit[static_cast<std::size_t>(level - spread.begin())], .all = all};
}

}  // namespace stof::firmware
