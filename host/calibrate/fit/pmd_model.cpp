#include "host/calibrate/fit/pmd_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/calib/pmd/ray_table.h"

namespace stof::host {
namespace {

constexpr double kPhaseSteps = 65536;
constexpr int kInverseSteps = 30;

std::int16_t to_steps(double turns, double least, double most) noexcept {
  return static_cast<std::int16_t>(std::lround(std::clamp(turns * kPhaseSteps, least, most)));
}

}  // namespace

double WigglingCurve::at(double phi) const noexcept {
  const double place = (phi - std::floor(phi)) * dsp::kWigglingSteps;
  const std::size_t step = static_cast<std::size_t>(place) % table.size();
  const double part = place - std::floor(place);
  double value = table[step] + part * (table[(step + 1) % table.size()] - table[step]);
  const std::complex<double> first = std::polar(1.0, kTurn * phi);
  std::complex<double> wave = 1;
  for (std::size_t h = 0; h < cosine.size(); ++h) {
    wave *= first;
    value += cosine[h] * wave.real() + sine[h] * wave.imag();
  }
  return value;
}

double WigglingCurve::slope(double phi) const noexcept {
  constexpr double kStep = 0.5 / dsp::kWigglingSteps;
  return (at(phi + kStep) - at(phi - kStep)) / (2 * kStep);
}

double WigglingCurve::inverse(double phi2) const noexcept {
  double phi1 = phi2;
  for (int i = 0; i < kInverseSteps; ++i) {
    const double next = phi2 + at(phi1);
    const double change = std::abs(next - phi1);
    phi1 = next;
    if (change < 1e-9) {
      break;
    }
  }
  return phi1;
}

double distance_to_wall(const WallTurn& turn, const std::array<double, 3>& ray,
                        double z_m) noexcept {
  return z_m / (ray[2] + turn[0] * ray[0] + turn[1] * ray[1]);
}

double half_path(std::span<const dsp::Emitter> emitters, const std::array<double, 3>& ray,
                 double distance_m) noexcept {
  double sum = 0;
  double weights = 0;
  for (const dsp::Emitter& e : emitters) {
    const double forward = distance_m * ray[2] - e[2];
    const double way = std::hypot(distance_m * ray[0] - e[0], distance_m * ray[1] - e[1], forward);
    const double square = way * way;
    const double cosine2 = forward * forward / square;
    const double weight = cosine2 * cosine2 / square;
    sum += weight * way;
    weights += weight;
  }
  return weights > 0 ? (sum / weights + distance_m) / 2 : distance_m;
}

double wrapped(double turns) noexcept { return turns - std::round(turns); }

PmdModel model_of(const dsp::PmdSensor& sensor) {
  PmdModel model;
  model.turn_m = dsp::kLightMetresPerSecond / (2.0 * sensor.frequency.modulation.value);
  model.phase_falls = sensor.phase_falls;
  model.scale = sensor.scale;
  model.shift_m = sensor.shift_m;
  model.offset = wrapped(sensor.frequency.offset_m / model.turn_m);
  for (std::size_t i = 0; i < model.wiggling.table.size(); ++i) {
    model.wiggling.table[i] = sensor.frequency.wiggling[i] / kPhaseSteps;
  }
  model.stray = {sensor.frequency.stray_i_lsb, sensor.frequency.stray_q_lsb};
  model.emitters.assign(sensor.emitters.begin(), sensor.emitters.begin() + sensor.emitter_count);
  for (const std::int16_t value : sensor.fixed_pattern) {
    model.pattern.push_back(value / kPhaseSteps);
  }
  return model;
}

void put_model(const PmdModel& model, dsp::PmdSensor& sensor, std::vector<std::int16_t>& pattern) {
  sensor.phase_falls = model.phase_falls;
  sensor.frequency.offset_m = model.offset * model.turn_m;
  sensor.scale = model.scale;
  sensor.shift_m = model.shift_m;
  for (std::size_t i = 0; i < sensor.frequency.wiggling.size(); ++i) {
    const double phi = static_cast<double>(i) / dsp::kWigglingSteps;
    sensor.frequency.wiggling[i] = to_steps(model.wiggling.at(phi), -32767, 32767);
  }
  sensor.frequency.stray_i_lsb = model.stray.real();
  sensor.frequency.stray_q_lsb = model.stray.imag();
  sensor.emitter_count = static_cast<int>(std::min(model.emitters.size(), sensor.emitters.size()));
  std::copy_n(model.emitters.begin(), sensor.emitter_count, sensor.emitters.begin());
  pattern.clear();
  for (const double turns : model.pattern) {
    pattern.push_back(to_steps(wrapped(turns), -32767, 32767));
  }
  sensor.fixed_pattern = pattern;
}

std::vector<std::array<double, 3>> rays_of(const dsp::Pinhole& lens) {
  std::vector<std::array<double, 3>> rays;
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      rays.push_back(dsp::unit_ray(lens, u, v));
    }
  }
  return rays;
}

}  // namespace stof::host
