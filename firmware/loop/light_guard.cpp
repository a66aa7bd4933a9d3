#include "firmware/loop/light_guard.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stof::firmware {
namespace {

constexpr int kWatchedRowStep = 4;
constexpr int kPixelsForEachLit = 8;      // of a picture with much light
constexpr int kPixelsForEachStray = 256;  // of one without any
constexpr int kVariances = 40;
constexpr int kSamples = 4;
constexpr int kQ16 = 16;

// 40 times a variance. Limited so that it can be computed with, whatever a calibration says.
std::int64_t threshold_q16(double variance) noexcept {
  constexpr double kOne = 1 << kQ16;
  constexpr double kLimit = 1e13;
  return std::llround(std::clamp(kVariances * kOne * variance, -kLimit, kLimit));
}

}  // namespace

LightGuard::LightGuard(const dsp::PmdSensor& sensor) noexcept
    : least_square_(4 * std::int64_t{sensor.min_amplitude_lsb} * sensor.min_amplitude_lsb),
      noise_q16_(
          threshold_q16(sensor.noise_lsb * sensor.noise_lsb +
                        (sensor.suppressed_lsb - sensor.dark_lsb) / sensor.electrons_per_lsb)),
      shot_q16_(threshold_q16(1 / (kSamples * sensor.electrons_per_lsb))) {}

bool LightGuard::gone(const hal::PmdFrame& frame) noexcept {
  int lit = 0;
  int all = 0;
  for (int y = 0; y < frame.samples[0].height(); y += kWatchedRowStep) {
    const auto a0 = frame.samples[0].row(y);
    const auto a1 = frame.samples[1].row(y);
    const auto a2 = frame.samples[2].row(y);
    const auto a3 = frame.samples[3].row(y);
    for (std::size_t x = 0; x < a0.size(); ++x) {
      const std::int64_t in_phase = int{a0[x]} - int{a2[x]};
      const std::int64_t quadrature = int{a1[x]} - int{a3[x]};
      const std::int64_t sum = int{a0[x]} + int{a1[x]} + int{a2[x]} + int{a3[x]};
      const std::int64_t noise = (noise_q16_ + shot_q16_ * sum) >> kQ16;
      lit += in_phase * in_phase + quadrature * quadrature > std::max(least_square_, noise) ? 1 : 0;
    }
    all += static_cast<int>(a0.size());
  }
  if (lit * kPixelsForEachStray > all) {
    was_lit_ = lit * kPixelsForEachLit >= all;
    return false;
  }
  return was_lit_;
}

}  // namespace stof::firmware
