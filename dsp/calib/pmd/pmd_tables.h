#pragma once

#include <cstdint>
#include <optional>

#include "dsp/calib/pmd_sensor.h"
#include "dsp/pmd/interval/sigma.h"
#include "dsp/pmd/phase/correct_phase.h"
#include "dsp/pmd/phase/phase.h"
#include "dsp/pmd/pmd_maps.h"
#include "dsp/pmd/range/phase_to_distance.h"

// A sensor's constants for the kernels of dsp/pmd in fixed point, rounded once at start, and the
// same for a frame's integration time and temperature. All take a sensor that problem() accepts.
namespace stof::dsp {

// One frequency at the reference integration time and temperature.
struct FrequencyTables {
  PhaseLimits limits;  // of the reference; stray light and suppressed light follow:
  std::int32_t stray_i_q8 = 0;
  std::int32_t stray_q_q8 = 0;
  std::uint32_t asymmetry_dark = 0;        // what asymmetry_base has without suppressed light
  std::uint32_t asymmetry_suppressed = 0;  // and what that adds
  float per_asymmetry_limit = 0;           // what asks for kPmdAsymmetric, times this: one sigma
  float sigma_unit = 0;                    // sigma of a distance: this, noise of a sample / amp2
  NoiseModel noise;                        // without suppressed light
  float noise_suppressed = 0;              // what that adds to its base
  PhaseCorrection correction;              // at the reference temperature
  std::int32_t global_per_k_q8 = 0;        // phase units for each kelvin above it
  std::int32_t reference_q8 = 0;           // that temperature
  std::uint32_t turn = 1;                  // units
};
FrequencyTables frequency_tables(const PmdSensor& sensor, const PmdFrequency& frequency) noexcept;

// Light that is always there grows with the integration time.
PhaseLimits limits_at(const FrequencyTables& frequency, IntegrationQ8 integration) noexcept;
NoiseModel noise_at(const FrequencyTables& frequency, IntegrationQ8 integration) noexcept;
// correction.global at a temperature: global + (per_k (T - T_ref)), it wraps.
Phase global_at(const FrequencyTables& frequency,
                std::optional<std::int32_t> temperature_q8) noexcept;

// Whether distances are computed in 0.1 mm and published as u32 too: with a second frequency, or
// when a turn is more than u16 quarter mm hold (below 9.15 MHz). Else they are computed in quarter
// mm.
bool has_long_range(const PmdSensor& sensor) noexcept;
double units_per_metre(const PmdSensor& sensor) noexcept;

// Distance of one turn of phase.
double turn_m(const PmdFrequency& frequency) noexcept;

// From distances to what is published; they repeat after range_m.
struct RangeTables {
  std::uint32_t unit_q30 = 0;  // of to_quarter_mm
  LinearDistanceCorrection line;
  std::uint32_t range = 0;  // PmdMaps::range
  QuarterMm widest = 0;     // PmdMaps::widest
};
RangeTables range_tables(const PmdSensor& sensor, double range_m) noexcept;

// sigma = a + b z + c z^2, both in cm, by distance; at least 1 unit.
SigmaCurve sigma_curve(const SigmaPolynomial& polynomial) noexcept;

}  // namespace stof::dsp
