#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/units.h"
#include "dsp/calib/pinhole.h"

// The calibration of a PMD camera and its lights.
namespace stof::dsp {

// W(phase), one turn in 128 steps, in units of 1/65536 turn: what wiggling adds to the phase.
inline constexpr int kWigglingSteps = 128;
using WigglingTable = std::array<std::int16_t, kWigglingSteps>;

// W(phi) = amplitude sin(4 phi).
WigglingTable fourth_harmonic_table(double amplitude_rad) noexcept;

// What odd harmonics of the correlation add to a phase, by the phase that is measured: of I + jQ ~
// e^jp + kappa3 e^-3jp + kappa5 e^5jp (tof noise model), W(arg) = arg - p. Near
// (kappa5 - kappa3) sin(4 phi), but at 0.04 rad and 20 MHz 3.5 mm off that, eight times a turn.
// |kappa3| + |kappa5| < 0.2: beyond that several phases may be measured as one.
WigglingTable wiggling_of_harmonics(double kappa3, double kappa5) noexcept;

// The constants of one modulation frequency.
struct PmdFrequency {
  Hertz modulation{20'000'000};
  double min_modulation_ratio = 0.30;  // A / (mean - dark), the chapter's 30 percent
  double offset_m = 0;                 // global distance offset, subtracted
  double offset_m_per_k = 0;           // of it, for each kelvin above reference_c
  WigglingTable wiggling{};
  // Light that comes back inside the camera, the same in every pixel and frame: what it adds to I
  // and Q, LSB at the reference integration time. It is subtracted before anything else.
  double stray_i_lsb = 0;
  double stray_q_lsb = 0;
};

// sigma = a + b z + c z^2, both in centimetres: Kuhnert & Stommel 2006, eq. 15.
struct SigmaPolynomial {
  double a = 0;
  double b = 0;
  double c = 0;
};

// The centre of a light, in the axes of the PMD lens. Metres.
using Emitter = std::array<double, 3>;
inline constexpr int kMaxEmitters = 4;

// One field for each constant of a calibration file.
struct PmdSensor {
  Pinhole lens;
  PmdFrequency frequency;
  std::optional<PmdFrequency> second =
      std::nullopt;           // a lower frequency that tells wrap counts apart
  bool phase_falls = false;   // a camera whose phase falls with distance
  double dark_lsb = 0;        // of one sample
  int saturation_lsb = 4095;  // a sample at or above it is saturated
  int under_lsb = 0;          // a sample at or below it is under range
  int min_amplitude_lsb = 4;  // of amplitude A (amp2 = 2 A)
  // |A0 + A2 - A1 - A3| above this many standard deviations of its noise: motion, changing light.
  double asymmetry_sigmas = 6;
  double electrons_per_lsb = 60;  // g of the noise model
  double noise_lsb = 5;           // n of the noise model: what a sample has without any light
  // Mean ambient light that the sensor suppresses, LSB at the reference integration time; its shot
  // noise stays.
  double suppressed_lsb = 0;
  // In place of the noise model: sigma from the distance alone.
  std::optional<SigmaPolynomial> sigma_polynomial = std::nullopt;
  double integration_us = 0;  // the reference integration time; 0 = frames are taken to have it
  double reference_c = 25;    // the temperature that offsets were measured at
  double scale = 1;           // straight line z = scale d + shift_m, after the wiggling (eq. 14)
  double shift_m = 0;
  // Lights beside the lens: the way out is not the way back. 0 emitters: at the lens.
  int emitter_count = 0;
  std::array<Emitter, kMaxEmitters> emitters{};
  // Amplitude A of a white surface, facing the camera in the middle of the picture at 1 m, at the
  // reference integration time: no surface is brighter. 0 = unknown. Tells wrap counts apart.
  double white_lsb = 0;
  // Distance offset of each pixel in 1/65536 turn of `frequency`, subtracted (of `second`: the same
  // in metres); width x height, row by row, or empty. Borrowed: whoever made the calibration keeps
  // it.
  std::span<const std::int16_t> fixed_pattern;
};

}  // namespace stof::dsp
