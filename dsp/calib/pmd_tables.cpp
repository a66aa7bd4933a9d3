#include "dsp/calib/pmd_tables.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "dsp/base/fixed.h"

namespace stof::dsp {
namespace {

// Saturating, for limits that may lie outside what a sample can be.
template <typename T>
T clamp_to(double value) noexcept {
  return static_cast<T>(
      std::clamp(std::round(value), 0.0, static_cast<double>(std::numeric_limits<T>::max())));
}

// Variance of one sample without any light in it, LSB^2: fixed noise, the shot noise of the light
// that is suppressed, and rounding to whole LSB.
double dark_variance(const PmdSensor& sensor) noexcept {
  constexpr double kRounding = 1.0 / 12;
  return sensor.suppressed_lsb / sensor.electrons_per_lsb + sensor.noise_lsb * sensor.noise_lsb +
         kRounding;
}

// Distance of one turn, quarter mm.
double turn_quarter_mm(const PmdSensor& sensor) noexcept {
  return kQuarterMmPerMetre * kLightMetresPerSecond / (2.0 * sensor.tone.modulation.value);
}

}  // namespace

PhaseLimits phase_limits(const PmdSensor& sensor) noexcept {
  PhaseLimits limits;
  limits.saturation = clamp_to<std::uint16_t>(sensor.saturation_lsb);
  limits.lowest = clamp_to<std::uint16_t>(sensor.under_lsb + 1.0);
  limits.dark = clamp_to<std::uint16_t>(sensor.dark_lsb);
  limits.min_amp2 = clamp_to<std::uint16_t>(2.0 * sensor.min_amplitude_lsb);
  limits.ratio_q16 =
      std::min(clamp_to<std::uint32_t>(2 * sensor.tone.min_modulation_ratio * 65536), kMaxRatioQ16);
  // A0 + A2 - A1 - A3 has four times the variance of a sample.
  const double squared = 4 * sensor.asymmetry_sigmas * sensor.asymmetry_sigmas;
  limits.asymmetry_base = clamp_to<std::uint32_t>(squared * dark_variance(sensor));
  limits.asymmetry_slope_q8 = std::min(
      clamp_to<std::uint32_t>(squared / sensor.electrons_per_lsb * 256), kMaxAsymmetrySlopeQ8);
  return limits;
}

RangeParams range_params(const PmdSensor& sensor) noexcept {
  RangeParams params;
  const double turn = turn_quarter_mm(sensor);
  params.phase_falls = sensor.phase_falls;
  params.range = clamp_to<std::uint16_t>(turn);
  const double turns = sensor.tone.offset_m * kQuarterMmPerMetre / turn;
  params.global = static_cast<Phase>(std::lround((turns - std::floor(turns)) * 65536));
  // K_s = sqrt(2) * 4000 c / (4 pi f) = sqrt(2) * turn / (2 pi).
  const double k = std::numbers::sqrt2 * turn / (2 * std::numbers::pi);
  params.noise_slope = static_cast<float>(k * k / sensor.electrons_per_lsb);
  params.noise_base = static_cast<float>(k * k * dark_variance(sensor));
  for (std::size_t i = 0; i < params.wiggling.size(); ++i) {
    const std::int16_t value = sensor.tone.wiggling[i];
    const std::int16_t next = sensor.tone.wiggling[(i + 1) % sensor.tone.wiggling.size()];
    params.wiggling[i] = {value, static_cast<std::int16_t>(next - value)};
  }
  return params;
}

}  // namespace stof::dsp
