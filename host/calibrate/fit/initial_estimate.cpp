#include "host/calibrate/fit/initial_estimate.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

namespace stof::host {
namespace {

// How far amplitudes stray from 1 / D^2: lights beside the lens, wiggling, the edge of the beam.
constexpr double kAmplitudeError = 0.15;

struct Guess {
  std::complex<double> signal;  // at 1 m
  std::complex<double> stray;
  double cost = std::numeric_limits<double>::infinity();
};

// I + jQ = signal a e^(j theta) + stray exposure: 2 complex unknowns, weighted least squares.
Guess solve(std::span<const Observation> seen, const PmdModel& model, const WallData& data,
            bool stray) {
  const Middle middle = middle_of(data.lens);
  Eigen::Matrix2cd normal = Eigen::Matrix2cd::Zero();
  Eigen::Vector2cd right = Eigen::Vector2cd::Zero();
  double total = 0;
  for (const Observation& o : seen) {
    const int width = data.lens.width;
    if (!middle.holds(static_cast<int>(o.pixel) % width, static_cast<int>(o.pixel) / width)) {
      continue;
    }
    const double path = half_path(model.emitters, data.rays[o.pixel], o.distance_m);
    const double theta =
        kTurn * model.wiggling.inverse((path - model.shift_m) / (model.scale * model.turn_m));
    const std::complex<double> shape =
        std::polar(o.exposure / (o.distance_m * o.distance_m), theta);
    const Eigen::RowVector2cd row(shape, stray ? o.exposure : 0.0);
    const double weight = 1 / (o.variance + kAmplitudeError * kAmplitudeError * std::norm(o.iq));
    normal += weight * row.adjoint() * row;
    right += weight * row.adjoint() * o.iq;
    total += weight * std::norm(o.iq);
  }
  if (!stray) {
    normal(1, 1) = 1;
  }
  const Eigen::Vector2cd x = normal.fullPivLu().solve(right);
  return {.signal = x[0], .stray = x[1], .cost = total - (x.adjoint() * right).value().real()};
}

}  // namespace

void estimate_initial_model(const WallData& data, bool sign_known, bool stray, PmdModel& model) {
  Guess best;
  bool falls = model.phase_falls;
  for (const bool candidate : {false, true}) {
    if (sign_known && candidate != model.phase_falls) {
      continue;
    }
    const Guess found = solve(observations(data, candidate), model, data, stray);
    if (found.cost < best.cost) {
      best = found;
      falls = candidate;
    }
  }
  model.phase_falls = falls;
  model.offset = std::arg(best.signal) / kTurn;
  if (stray) {
    model.stray = falls ? std::conj(best.stray) : best.stray;
  }
}

}  // namespace stof::host
