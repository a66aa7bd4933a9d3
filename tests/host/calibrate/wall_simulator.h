#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "host/calibrate/fit/pmd_model.h"
#include "host/calibrate/walls/pmd_wall.h"

// A PMD camera before a white wall, of which every constant is known: the four samples of each
// pixel from the way of the light, with noise, rounded to whole LSB. Knows nothing of how a
// calibration is found.
namespace stof::test {

// A member for each constant that a camera has.
struct SimulatedCamera {
  dsp::Pinhole lens{.width = 32, .height = 24, .fx = 30, .fy = 30, .cx = 16.2, .cy = 11};
  std::uint32_t f_mod_hz = 30'000'000;
  bool phase_falls = false;
  double offset_m = 0;  // what the phase shows too much
  double scale = 1;     // z = scale d
  // Amplitudes of sin(h phi) and cos(h phi), h = 1 .. 8, metres of distance.
  host::WigglingCurve wiggling;
  double pattern_m = 0;  // rms of the fixed pattern
  std::complex<double> stray;
  std::vector<dsp::Emitter> emitters;
  double electrons_per_lsb = 40;
  double noise_lsb = 4;
  double white_lsb = 900;  // amplitude of a white surface at 1 m
  double contrast = 0.5;   // amplitude over level
  double dark_lsb = 80;
  int saturation_lsb = 4095;
  double albedo = 0.9;
  std::array<double, 2> wall_turn{};  // x/z and y/z of the normal of all walls
};

// Of each pixel, metres; mean 0.
std::vector<double> pattern_of(const SimulatedCamera& camera);

// `frames` frames of a wall at z_m; exposure scales all light. The seed makes the noise.
host::WallRecording record(const SimulatedCamera& camera, double z_m, int frames,
                           std::uint64_t seed, double exposure = 1);

std::vector<host::Wall> record_walls(const SimulatedCamera& camera, const std::vector<double>& z_m,
                                     int frames, std::uint64_t seed);

}  // namespace stof::test
