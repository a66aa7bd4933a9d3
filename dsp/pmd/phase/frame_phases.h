#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/calib/pmd/pmd_tables.h"
#include "dsp/pmd/converter.h"
#include "dsp/pmd/phase/merge_exposures.h"
#include "dsp/pmd/phase/phase.h"

// From the exposures of one frequency to one row of phases with amplitude, offset, sigma and flags.
// For PmdConverter alone.
namespace stof::dsp {

// Parameters of the row kernels for one exposure of a frame.
struct ExposureTables {
  std::size_t index = 0;  // in the frame
  PhaseLimits limits;
  NoiseModel noise;
  std::uint16_t gain_q8 = kUnchangedQ8;  // of the longest over this one
};

// Their parameters for one frequency of a frame.
struct FrameTables {
  FrequencyTables frequency;
  PhaseCorrection correction;                                // at the frame's temperature
  std::array<ExposureTables, kMaxPmdExposures> exposures{};  // the longest first
};
FrameTables make_frame_tables(const PmdSensor& sensor, const PmdFrequency& frequency) noexcept;

// CHECKs that these are 1 to kMaxPmdExposures exposures of width x height.
void check_exposures(std::span<const PmdExposure> exposures, int width, int height) noexcept;

// Integration times and temperature of a frame become exposures and correction of `tables`.
// Returns the longest integration time.
IntegrationQ8 prepare_frame_tables(std::span<const PmdExposure> exposures,
                                   std::optional<std::int32_t> temperature_q8,
                                   FrameTables& tables) noexcept;

ExposureRow take_exposure_row(Arena& arena, std::size_t width) noexcept;

// Rows that are overwritten while several exposures are merged.
struct MergeRows {
  ExposureRow shorter;
  std::span<std::uint8_t> taken;
};

// Row y of an exposure's samples.
SampleRows sample_rows(const PmdSamples& samples, int y) noexcept;

// Row y of one frequency: phase, amplitude, offset, ratio, flags, and sigma by the noise model.
// amp2 and offset are those of the longest exposure.
void measure_phases(std::span<const PmdExposure> exposures, int y, const FrameTables& tables,
                    const MergeRows& spare, const ExposureRow& out) noexcept;

}  // namespace stof::dsp
