#include "host/calibrate/fit/pmd_measures.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

constexpr double kNearestWhiteM = 1;  // nearer, lights are no points

double longest_exposure(const WallData& data) {
  double longest = 0;
  for (const Wall& wall : data.walls) {
    longest = std::max(longest, wall.exposure);
  }
  return longest;
}

std::complex<double> signal_of(const Reading& reading, const Wall& wall, const PmdModel& model) {
  return std::complex<double>(reading.i, reading.q) - wall.exposure * model.stray;
}

// Root mean square over the middle of the wall; 0: no pixel tells.
double spread_of(const Wall& wall, const WallData& data, const PmdModel& model) {
  const Middle middle = middle_of(data.lens);
  double sum = 0;
  double count = 0;
  for (int y = middle.top; y < middle.bottom && wall.frames > 1; ++y) {
    for (int x = middle.left; x < middle.right; ++x) {
      const Reading& r = wall.readings[static_cast<std::size_t>(y * data.lens.width + x)];
      const double signal = std::norm(signal_of(r, wall, model));
      if (!r.saturated && signal > 4 * data.min_amplitude_lsb * data.min_amplitude_lsb) {
        sum += r.spread_iq / signal;
        count += 1;
      }
    }
  }
  const double radian_m = model.turn_m * model.scale / (2 * std::numbers::pi);
  return count > 0 ? std::sqrt(sum / count) * radian_m : 0;
}

}  // namespace

std::size_t drop_blind(std::vector<Wall>& walls, const dsp::PmdSensor& camera) {
  const std::vector<std::array<double, 3>> rays = rays_of(camera.lens);
  return std::erase_if(walls, [&](const Wall& wall) {
    for (std::size_t p = 0; p < rays.size(); ++p) {
      const Reading& reading = wall.readings[p];
      if (rays[p][2] > 0 && !reading.saturated &&
          std::hypot(reading.i, reading.q) >= 2 * camera.min_amplitude_lsb) {
        return false;
      }
    }
    return true;
  });
}

std::size_t count_distances(const std::vector<Wall>& walls) {
  std::vector<double> z;
  z.reserve(walls.size());
  for (const Wall& wall : walls) {
    z.push_back(wall.z_m);
  }
  std::ranges::sort(z);
  z.erase(std::ranges::unique(z).begin(), z.end());
  return z.size();
}

double white_amplitude(const WallData& data, const PmdModel& model, double albedo) {
  std::vector<double> found;
  const Middle middle = middle_of(data.lens);
  for (const double forward : {0.995, 0.97}) {
    for (const Wall& wall : data.walls) {
      for (std::size_t p = 0; p < data.rays.size() && wall.z_m >= kNearestWhiteM; ++p) {
        const int x = static_cast<int>(p) % data.lens.width;
        const int y = static_cast<int>(p) / data.lens.width;
        const Reading& reading = wall.readings[p];
        if (!middle.holds(x, y) || reading.saturated || data.rays[p][2] < forward) {
          continue;
        }
        const double amplitude = std::abs(signal_of(reading, wall, model)) / (2 * wall.exposure);
        found.push_back(amplitude * wall.z_m * wall.z_m / albedo);
      }
    }
    if (!found.empty()) {
      break;
    }
  }
  return median(std::move(found)).value_or(0);
}

std::optional<dsp::SigmaPolynomial> measured_sigma(const WallData& data, const PmdModel& model) {
  std::vector<SigmaPoint> points;
  for (const Wall& wall : data.walls) {
    // Another integration time is another curve.
    if (wall.exposure == longest_exposure(data)) {
      points.push_back({.z_m = wall.z_m, .sigma_m = spread_of(wall, data, model)});
    }
  }
  return fit_sigma(points);
}

double widest_gap(const WallData& data, const PmdModel& model) {
  std::vector<double> phases;
  for (const Observation& o : observations(data, model.phase_falls)) {
    const double turns = o.distance_m / model.turn_m;
    phases.push_back(turns - std::floor(turns));
  }
  if (phases.empty()) {
    return 1;
  }
  std::ranges::sort(phases);
  double gap = phases.front() + 1 - phases.back();
  for (std::size_t i = 1; i < phases.size(); ++i) {
    gap = std::max(gap, phases[i] - phases[i - 1]);
  }
  return gap;
}

}  // namespace stof::host
