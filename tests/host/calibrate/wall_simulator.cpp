#include "tests/host/calibrate/wall_simulator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/base/units.h"
#include "dsp/calib/pmd/ray_table.h"
#include "tests/support/random.h"

namespace stof::test {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Mean 0, standard deviation 1 (Box and Muller).
double normal(Random& random) {
  constexpr int kFine = 1 << 30;
  const double u = (random.between(1, kFine)) / static_cast<double>(kFine);
  const double v = random.between(0, kFine) / static_cast<double>(kFine);
  return std::sqrt(-2 * std::log(u)) * std::cos(kTurn * v);
}

double turn_m(const SimulatedCamera& camera) {
  return dsp::kLightMetresPerSecond / (2.0 * camera.f_mod_hz);
}

// phi1 with phi1 - W(phi1) = phi2 by bisection; W in metres.
double bent(const SimulatedCamera& camera, double phi2) {
  double low = phi2 - 0.2;
  double high = phi2 + 0.2;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    const bool below = middle - camera.wiggling.at(middle) / turn_m(camera) < phi2;
    (below ? low : high) = middle;
  }
  return low;
}

// Half the way of the light, of several lights weighted by what comes back from each.
double half_way(const SimulatedCamera& camera, const std::array<double, 3>& at) {
  const double back = std::hypot(at[0], at[1], at[2]);
  double sum = 0;
  double weights = 0;
  for (const dsp::Emitter& e : camera.emitters) {
    const double out = std::hypot(at[0] - e[0], at[1] - e[1], at[2] - e[2]);
    const double weight = std::pow((at[2] - e[2]) / out, 4) / (out * out);
    sum += weight * out;
    weights += weight;
  }
  return camera.emitters.empty() ? back : (sum / weights + back) / 2;
}

}  // namespace

std::vector<double> pattern_of(const SimulatedCamera& camera) {
  const std::size_t pixels =
      static_cast<std::size_t>(camera.lens.width) * static_cast<std::size_t>(camera.lens.height);
  std::vector<double> pattern(pixels);
  Random random(99);
  double sum = 0;
  for (double& value : pattern) {
    value = camera.pattern_m * normal(random);
    sum += value;
  }
  for (double& value : pattern) {
    value -= sum / static_cast<double>(pixels);
  }
  return pattern;
}

host::WallRecording record(const SimulatedCamera& camera, double z_m, int frames,
                           std::uint64_t seed, double exposure) {
  const int width = camera.lens.width;
  const int height = camera.lens.height;
  const std::vector<double> pattern = pattern_of(camera);
  host::WallRecording wall{.name = "z" + std::to_string(std::lround(z_m * 1000)),
                           .z_m = z_m,
                           .exposure = exposure,
                           .recording = {}};
  dsp::PmdSensor& sensor = wall.recording.calibration.pmd;
  sensor.lens = camera.lens;
  sensor.frequency.modulation.value = camera.f_mod_hz;
  sensor.dark_lsb = camera.dark_lsb;
  sensor.saturation_lsb = camera.saturation_lsb;
  wall.recording.frames.assign(static_cast<std::size_t>(frames),
                               dataset::Image<std::uint16_t>(width, 4 * height));
  Random random(seed);
  for (int p = 0; p < width * height; ++p) {
    const int column = p % width;
    const int row = p / width;
    const std::array<double, 3> ray = dsp::unit_ray(camera.lens, column, row);
    const double d = z_m / (ray[2] + camera.wall_turn[0] * ray[0] + camera.wall_turn[1] * ray[1]);
    const double way = half_way(camera, {ray[0] * d, ray[1] * d, ray[2] * d});
    const double phi = bent(camera, way / (camera.scale * turn_m(camera))) +
                       (camera.offset_m + pattern[static_cast<std::size_t>(p)]) / turn_m(camera);
    const double amplitude =
        exposure * camera.white_lsb * camera.albedo * std::pow(ray[2], 4) / (z_m * z_m);
    const double angle = kTurn * (camera.phase_falls ? -phi : phi);
    // I + jQ = 2 A e^(j angle) + stray.
    const std::complex<double> iq = std::polar(2 * amplitude, angle) + exposure * camera.stray;
    const std::array<double, 4> light{iq.real() / 2, -iq.imag() / 2, -iq.real() / 2, iq.imag() / 2};
    for (dataset::Image<std::uint16_t>& frame : wall.recording.frames) {
      for (int k = 0; k < 4; ++k) {
        const double level = amplitude / camera.contrast + light[static_cast<std::size_t>(k)];
        const double noise = std::sqrt(std::max(level, 0.0) / camera.electrons_per_lsb +
                                       camera.noise_lsb * camera.noise_lsb) *
                             normal(random);
        const double sample = std::clamp(std::round(level + camera.dark_lsb + noise), 0.0,
                                         static_cast<double>(camera.saturation_lsb));
        frame.pixels[static_cast<std::size_t>(k * width * height + p)] =
            static_cast<std::uint16_t>(sample);
      }
    }
  }
  return wall;
}

std::vector<host::Wall> record_walls(const SimulatedCamera& camera, const std::vector<double>& z_m,
                                     int frames, std::uint64_t seed) {
  std::vector<host::Wall> walls;
  walls.reserve(z_m.size());
  for (std::size_t n = 0; n < z_m.size(); ++n) {
    walls.push_back(host::summarise(record(camera, z_m[n], frames, seed + n), host::Frames::kAll));
  }
  return walls;
}

}  // namespace stof::test
