#pragma once

#include <cstdint>

#include "dsp/calib/calibration.h"

// The fields of a calibration file in the order of docs/WIRE.md, for calibration_file.cpp alone.
// A walker has version() and field(x) for each type of x; a structure is const or not.
namespace stof::wire {

inline constexpr std::uint16_t kFirstVersionWithOptions = 2;
// Lenses with k3, p1, p2; stray light, temperature, exposure, lights beside the lens.
inline constexpr std::uint16_t kFirstVersionWithLights = 3;

// Options that not every rig has; the fields follow in this order.
inline constexpr std::uint32_t kRawOption = 1;
inline constexpr std::uint32_t kConvergingOption = 2;
inline constexpr std::uint32_t kSecondFrequencyOption = 4;
inline constexpr std::uint32_t kSigmaOption = 8;

// A field that was added to the calibration must be added to the file, with a new version.
static_assert(sizeof(dsp::Calibration) == 1472);

template <typename Walker, typename Lens>
void walk_lens(Walker& walker, Lens& lens) noexcept {
  walker.field(lens.width);
  walker.field(lens.height);
  walker.field(lens.fx);
  walker.field(lens.fy);
  walker.field(lens.cx);
  walker.field(lens.cy);
  walker.field(lens.k1);
  walker.field(lens.k2);
  if (walker.version() >= kFirstVersionWithLights) {
    walker.field(lens.k3);
    walker.field(lens.p1);
    walker.field(lens.p2);
  }
}

template <typename Walker, typename Transform>
void walk_transform(Walker& walker, Transform& transform) noexcept {
  for (auto& element : transform.rotation) {
    walker.field(element);
  }
  for (auto& element : transform.translation_m) {
    walker.field(element);
  }
}

// The fields that version 3 added to the frequency that every file has.
template <typename Walker, typename Frequency>
void walk_rest_of_frequency(Walker& walker, Frequency& frequency) noexcept {
  walker.field(frequency.offset_m_per_k);
  walker.field(frequency.stray_i_lsb);
  walker.field(frequency.stray_q_lsb);
}

template <typename Walker, typename Frequency>
void walk_wiggling(Walker& walker, Frequency& frequency) noexcept {
  for (auto& step : frequency.wiggling) {
    walker.field(step);
  }
}

template <typename Walker, typename Sensor>
void walk_exposure_and_lights(Walker& walker, Sensor& pmd) noexcept {
  walker.field(pmd.integration_us);
  walker.field(pmd.reference_c);
  walker.field(pmd.scale);
  walker.field(pmd.shift_m);
  walker.field(pmd.white_lsb);
  walker.field(pmd.emitter_count);
  for (auto& emitter : pmd.emitters) {
    for (auto& coordinate : emitter) {
      walker.field(coordinate);
    }
  }
}

// Everything but the options and the fixed pattern. Calib is dsp::Calibration or const
// dsp::Calibration.
template <typename Walker, typename Calib>
void walk(Walker& walker, Calib& calibration) noexcept {
  walk_lens(walker, calibration.stereo.left);
  walker.field(calibration.stereo.baseline_m);
  walker.field(calibration.stereo.doff_px);
  auto& pmd = calibration.pmd;
  walk_lens(walker, pmd.lens);
  walker.field(pmd.frequency.modulation.value);
  walker.field(pmd.phase_falls);
  walker.field(pmd.saturation_lsb);
  walker.field(pmd.under_lsb);
  walker.field(pmd.min_amplitude_lsb);
  walker.field(pmd.dark_lsb);
  walker.field(pmd.frequency.min_modulation_ratio);
  walker.field(pmd.asymmetry_sigmas);
  walker.field(pmd.electrons_per_lsb);
  walker.field(pmd.noise_lsb);
  walker.field(pmd.suppressed_lsb);
  walker.field(pmd.frequency.offset_m);
  walk_wiggling(walker, pmd.frequency);
  if (walker.version() >= kFirstVersionWithLights) {
    walk_rest_of_frequency(walker, pmd.frequency);
    walk_exposure_and_lights(walker, pmd);
  }
  walk_transform(walker, calibration.pmd_to_stereo);
}

template <typename Walker, typename Rig>
void walk_pairs(Walker& walker, Rig& rig) noexcept {
  if (rig.raw) {
    walk_lens(walker, rig.raw->left);
    walk_lens(walker, rig.raw->right);
    walk_transform(walker, rig.raw->left_to_right);
  }
  if (rig.converging) {
    walker.field(rig.converging->alpha_rad);
    walker.field(rig.converging->beta_rad);
    walker.field(rig.converging->f1_m);
    walker.field(rig.converging->f2_m);
    walker.field(rig.converging->pixel_m);
    walker.field(rig.converging->cx_left);
    walker.field(rig.converging->cx_right);
  }
}

template <typename Walker, typename Calib>
void walk_options(Walker& walker, Calib& calibration) noexcept {
  walk_pairs(walker, calibration.stereo);
  auto& pmd = calibration.pmd;
  if (pmd.second) {
    walker.field(pmd.second->modulation.value);
    walker.field(pmd.second->min_modulation_ratio);
    walker.field(pmd.second->offset_m);
    walk_wiggling(walker, *pmd.second);
    walk_rest_of_frequency(walker, *pmd.second);
  }
  if (pmd.sigma_polynomial) {
    walker.field(pmd.sigma_polynomial->a);
    walker.field(pmd.sigma_polynomial->b);
    walker.field(pmd.sigma_polynomial->c);
  }
}

}  // namespace stof::wire
