#include "dsp/calib/pmd/pmd_tables.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "dsp/base/fixed.h"
#include "dsp/pmd/range/to_quarter_mm.h"

namespace stof::dsp {
namespace {

constexpr int kQ8 = 256;
constexpr double kUnitsOfLongRange = 10000;  // 0.1 mm

// Saturating, for limits that may lie outside what a sample can be.
template <typename T>
T clamp_to(double value) noexcept {
  return static_cast<T>(std::clamp(std::round(value),
                                   static_cast<double>(std::numeric_limits<T>::lowest()),
                                   static_cast<double>(std::numeric_limits<T>::max())));
}

// Variance of one sample without any light in it, LSB^2: fixed noise and rounding to whole LSB.
double dark_variance(const PmdSensor& sensor) noexcept {
  constexpr double kRounding = 1.0 / 12;
  return sensor.noise_lsb * sensor.noise_lsb + kRounding;
}

// Metres as phase units of a frequency, whole turns dropped.
Phase wrapped_phase(const PmdFrequency& frequency, double metres) noexcept {
  const double turns = metres / turn_m(frequency);
  return static_cast<Phase>(std::lround((turns - std::floor(turns)) * 65536));
}

PhaseLimits phase_limits(const PmdSensor& sensor, const PmdFrequency& frequency,
                         double squared) noexcept {
  PhaseLimits limits;
  limits.saturation = clamp_to<std::uint16_t>(sensor.saturation_lsb);
  limits.lowest = clamp_to<std::uint16_t>(sensor.under_lsb + 1.0);
  limits.dark = clamp_to<std::uint16_t>(sensor.dark_lsb);
  limits.min_amp2 = clamp_to<std::uint16_t>(2.0 * sensor.min_amplitude_lsb);
  limits.ratio_q16 = 2 * std::min(clamp_to<std::uint32_t>(frequency.min_modulation_ratio * 65536),
                                  kMaxRatioQ16 / 2);
  limits.asymmetry_slope_q8 = std::min(
      clamp_to<std::uint32_t>(squared / sensor.electrons_per_lsb * kQ8), kMaxAsymmetrySlopeQ8);
  return limits;
}

PhaseCorrection correction_of(const PmdSensor& sensor, const PmdFrequency& frequency) noexcept {
  PhaseCorrection correction;
  correction.phase_falls = sensor.phase_falls;
  correction.global = wrapped_phase(frequency, frequency.offset_m);
  correction.pattern_scale_q14 = clamp_to<std::uint16_t>(
      turn_m(sensor.frequency) / turn_m(frequency) * static_cast<double>(kPatternScaleOne));
  for (std::size_t i = 0; i < correction.wiggling.size(); ++i) {
    const std::int16_t value = frequency.wiggling[i];
    const std::int16_t next = frequency.wiggling[(i + 1) % frequency.wiggling.size()];
    correction.wiggling[i] = {value, static_cast<std::int16_t>(next - value)};
  }
  return correction;
}

}  // namespace

double turn_m(const PmdFrequency& frequency) noexcept {
  return kLightMetresPerSecond / (2.0 * frequency.modulation.value);
}

FrequencyTables frequency_tables(const PmdSensor& sensor, const PmdFrequency& frequency) noexcept {
  // A0 + A2 - A1 - A3 has four times the variance of a sample.
  const double squared = 4 * sensor.asymmetry_sigmas * sensor.asymmetry_sigmas;
  const double suppressed = sensor.suppressed_lsb / sensor.electrons_per_lsb;
  // K_s = sqrt(2) * 4000 c / (4 pi f) = sqrt(2) * turn / (2 pi).
  const double k =
      std::numbers::sqrt2 * turn_m(frequency) * kQuarterMmPerMetre / (2 * std::numbers::pi);
  return {.limits = phase_limits(sensor, frequency, squared),
          .stray_i_q8 = clamp_to<std::int32_t>(frequency.stray_i_lsb * kQ8),
          .stray_q_q8 = clamp_to<std::int32_t>(frequency.stray_q_lsb * kQ8),
          .asymmetry_dark = clamp_to<std::uint32_t>(squared * dark_variance(sensor)),
          .asymmetry_suppressed = clamp_to<std::uint32_t>(squared * suppressed),
          .per_asymmetry_limit = static_cast<float>(1 / sensor.asymmetry_sigmas),
          .sigma_unit = static_cast<float>(k),
          .noise = {.slope = static_cast<float>(k * k / sensor.electrons_per_lsb),
                    .base = static_cast<float>(k * k * dark_variance(sensor))},
          .noise_suppressed = static_cast<float>(k * k * suppressed),
          .correction = correction_of(sensor, frequency),
          .global_per_k_q8 =
              clamp_to<std::int32_t>(frequency.offset_m_per_k / turn_m(frequency) * 65536 * kQ8),
          .reference_q8 = clamp_to<std::int32_t>(sensor.reference_c * kQ8),
          .turn = clamp_to<std::uint32_t>(turn_m(frequency) * units_per_metre(sensor))};
}

PhaseLimits limits_at(const FrequencyTables& frequency, IntegrationQ8 integration) noexcept {
  PhaseLimits limits = frequency.limits;
  const auto stray = [integration](std::int32_t q8) {
    const std::int64_t lsb = round_shift(std::int64_t{q8} * integration, 16);
    return static_cast<std::int16_t>(std::clamp<std::int64_t>(lsb, -32767, 32767));
  };
  limits.stray_i = stray(frequency.stray_i_q8);
  limits.stray_q = stray(frequency.stray_q_q8);
  const std::uint64_t suppressed =
      round_shift(std::uint64_t{frequency.asymmetry_suppressed} * integration, 8);
  limits.asymmetry_base = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(frequency.asymmetry_dark + suppressed, 0xFFFFFFFF));
  return limits;
}

NoiseModel noise_at(const FrequencyTables& frequency, IntegrationQ8 integration) noexcept {
  const float relative = static_cast<float>(integration) / kQ8;
  return {frequency.noise.slope, frequency.noise.base + frequency.noise_suppressed * relative};
}

Phase global_at(const FrequencyTables& frequency,
                std::optional<std::int32_t> temperature_q8) noexcept {
  const std::int64_t warmer =
      std::int64_t{temperature_q8.value_or(frequency.reference_q8)} - frequency.reference_q8;
  const std::int64_t moved = round_shift(frequency.global_per_k_q8 * warmer, 16);
  return static_cast<Phase>(frequency.correction.global + moved);
}

bool has_long_range(const PmdSensor& sensor) noexcept {
  return sensor.second.has_value() ||
         std::round(turn_m(sensor.frequency) * kQuarterMmPerMetre) > kMaxQuarterMm;
}

double units_per_metre(const PmdSensor& sensor) noexcept {
  return has_long_range(sensor) ? kUnitsOfLongRange : kQuarterMmPerMetre;
}

RangeTables range_tables(const PmdSensor& sensor, double range_m) noexcept {
  const double units = units_per_metre(sensor);
  constexpr double kMost = kMostUnits;
  RangeTables tables;
  tables.unit_q30 = has_long_range(sensor) ? kTenthMmQ30 : kQuarterMmQ30;
  tables.line = {
      .scale_q15 =
          std::min(clamp_to<std::uint32_t>(sensor.scale * LinearDistanceCorrection::kPlainScale),
                   LinearDistanceCorrection::kMostScale),
      .shift =
          static_cast<std::int32_t>(std::clamp(std::round(sensor.shift_m * units), -kMost, kMost)),
      .turn = std::min(clamp_to<std::uint32_t>(range_m * sensor.scale * units), kMostUnits)};
  tables.range = clamp_to<std::uint32_t>(range_m * sensor.scale * kQuarterMmPerMetre);
  tables.widest = clamp_to<QuarterMm>(
      std::floor(turn_m(sensor.frequency) * sensor.scale * kQuarterMmPerMetre / 2));
  return tables;
}

SigmaCurve sigma_curve(const SigmaPolynomial& polynomial) noexcept {
  constexpr double kQuarterMmPerCm = 40;
  constexpr int kStep = 1024;
  const auto at = [&polynomial](std::size_t i) {
    const double z = static_cast<double>(i * kStep) / kQuarterMmPerCm;
    const double sigma = polynomial.a + z * (polynomial.b + z * polynomial.c);
    return static_cast<std::int32_t>(
        std::clamp(std::round(sigma * kQuarterMmPerCm), 0.0, double{kMaxQuarterMm}));
  };
  SigmaCurve curve{};
  for (std::size_t i = 0; i < curve.size(); ++i) {
    curve[i] = {at(i), at(i + 1) - at(i)};
  }
  return curve;
}

}  // namespace stof::dsp
