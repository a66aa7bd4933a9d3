#pragma once

#include <array>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include "dsp/calib/pmd_sensor.h"

// The model of a PMD sensor, in double precision: the appliance's conversion (dsp/pmd) read
// backwards. A pixel that sees a surface at radial distance D:
//   path  = mean over the lights e of (|D r - e| + D) / 2, weighted by what comes back from each
//           (dsp/calib/pmd/emitter_offset_table.h), D without lights
//   phi2  = (path - shift) / (scale turn), turn = c / (2 f)
//   phi1  - W(phi1) = phi2
//   I + jQ = A exp(+-2 pi j (phi1 + offset + pattern)) + stray; minus where the phase falls
// Phases are in turns, distances in metres.
namespace stof::host {

inline constexpr double kTurn = 2 * std::numbers::pi;

inline constexpr int kHarmonics = 8;

// W: the table of an older calibration, or harmonics 1 .. 8.
struct WigglingCurve {
  std::array<double, kHarmonics> cosine{};
  std::array<double, kHarmonics> sine{};
  std::array<double, dsp::kWigglingSteps> table{};  // added to them, linear between the steps

  double at(double phi) const noexcept;
  double slope(double phi) const noexcept;  // dW / dphi
  // phi1 of phi1 - W(phi1) = phi2.
  double inverse(double phi2) const noexcept;
};

// x/z and y/z of the normal of walls that all stand alike; 0 where they face the camera.
using WallTurn = std::array<double, 2>;
// Along a unit ray, to a wall that meets the axis at z_m.
double distance_to_wall(const WallTurn& turn, const std::array<double, 3>& ray,
                        double z_m) noexcept;

struct PmdModel {
  double turn_m = 0;
  bool phase_falls = false;
  double offset = 0;
  double scale = 1;
  double shift_m = 0;  // kept from an older calibration, never fitted: offset says the same
  WigglingCurve wiggling;
  std::complex<double> stray;  // I + jQ, LSB at the reference integration time
  std::vector<dsp::Emitter> emitters;
  std::vector<double> pattern;  // of each pixel, or empty
  WallTurn wall_turn{};         // not of the sensor: how the walls stood
  double wall_shift_m = 0;      // nor this: of FitParts::shifted_wall
};

double half_path(std::span<const dsp::Emitter> emitters, const std::array<double, 3>& ray,
                 double distance_m) noexcept;
// Into -0.5 .. 0.5.
double wrapped(double turns) noexcept;

// Everything of the model that a sensor already has, and back. `pattern` keeps what the sensor's
// fixed_pattern borrows.
PmdModel model_of(const dsp::PmdSensor& sensor);
void put_model(const PmdModel& model, dsp::PmdSensor& sensor, std::vector<std::int16_t>& pattern);

// The unit rays of all pixels, row by row; {} where a pixel has none.
std::vector<std::array<double, 3>> rays_of(const dsp::Pinhole& lens);

}  // namespace stof::host
