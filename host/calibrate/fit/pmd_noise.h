#pragma once

#include <array>
#include <optional>
#include <span>

#include "dsp/calib/pmd_sensor.h"
#include "host/calibrate/walls/pmd_wall.h"

// How much the readings of a PMD sensor vary from frame to frame.
namespace stof::host {

// The noise of one sample: variance = (level + suppressed exposure) / g + n^2 + 1/12, LSB^2; the
// last is rounding to whole LSB.
struct SampleNoise {
  double electrons_per_lsb = 60;  // g
  double noise_lsb = 5;           // n
  double suppressed_lsb = 0;

  double variance(double level, double exposure) const noexcept;
};

// Fitted to the temporal variance of every pixel against its level. Light that is suppressed is
// told from n only where the walls have different exposures; else `before` says how much it is.
// None without walls of two frames or more, or where the variance does not grow with the level.
std::optional<SampleNoise> fit_noise(std::span<const Wall> walls, const SampleNoise& before);

struct SigmaPoint {
  double z_m = 0;
  double sigma_m = 0;
};
// sigma = a + b z + c z^2, both in centimetres (the chapter's eq. 15), with equal relative errors.
// None from fewer than three distances.
std::optional<dsp::SigmaPolynomial> fit_sigma(std::span<const SigmaPoint> points);
double sigma_at(const dsp::SigmaPolynomial& polynomial, double z_m) noexcept;  // metres

}  // namespace stof::host
