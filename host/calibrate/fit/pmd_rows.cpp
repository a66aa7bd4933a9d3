#include "host/calibrate/fit/pmd_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stof::host {
namespace {

// Standard deviations, far above what cameras have.
constexpr double kScalePrior = 0.05;
constexpr double kHarmonicPrior = 0.003;  // turns

// Along the ray of that pixel, to a wall turned so.
double distance_of(const FitParts& parts, const PmdModel& model, const std::array<double, 3>& ray,
                   const Observation& o) {
  const double shift = o.wall == parts.shifted_wall ? model.wall_shift_m : 0;
  return distance_to_wall(model.wall_turn, ray, o.distance_m * ray[2] + shift);
}

// By differences: these two are rarely asked for.
void wall_turn_columns(const WallData& data, const FitParts& parts, const PmdModel& model,
                       const Observation& o, double by_path, Row& row) {
  constexpr double kStep = 1e-4;
  const std::array<double, 3>& ray = data.rays[o.pixel];
  for (const std::size_t axis : {0U, 1U}) {
    PmdModel turned = model;
    turned.wall_turn[axis] += kStep;
    const double change = half_path(model.emitters, ray, distance_of(parts, turned, ray, o)) -
                          half_path(model.emitters, ray, distance_of(parts, model, ray, o));
    row.by[kWallTurnX + static_cast<int>(axis)] = by_path * change / kStep;
  }
}

void emitter_columns(const WallData& data, const FitParts& parts, const PmdModel& model,
                     const Observation& o, double by_path, Row& row) {
  constexpr double kStep = 1e-4;
  for (const int axis : {0, 1}) {
    PmdModel moved = model;
    move_emitters(moved, axis == 0 ? kStep : 0, axis == 0 ? 0 : kStep);
    const std::array<double, 3>& ray = data.rays[o.pixel];
    const double distance = distance_of(parts, model, ray, o);
    const double change =
        half_path(moved.emitters, ray, distance) - half_path(model.emitters, ray, distance);
    row.by[kEmitterX + axis] = by_path * change / kStep;
  }
}

double wall_shift_column(const WallData& data, const FitParts& parts, const PmdModel& model,
                         const Observation& o, double by_path) {
  constexpr double kStep = 1e-4;
  const std::array<double, 3>& ray = data.rays[o.pixel];
  PmdModel moved = model;
  moved.wall_shift_m += kStep;
  return by_path / kStep *
         (half_path(model.emitters, ray, distance_of(parts, moved, ray, o)) -
          half_path(model.emitters, ray, distance_of(parts, model, ray, o)));
}

}  // namespace

void move_emitters(PmdModel& model, double x, double y) {
  if (model.emitters.size() == 2) {
    model.emitters[0][0] -= x;
    model.emitters[1][0] += x;
    model.emitters[0][1] -= y;
    model.emitters[1][1] += y;
  } else if (!model.emitters.empty()) {
    model.emitters[0][0] += x;
    model.emitters[0][1] += y;
  }
}

bool is_active(const FitParts& parts, int unknown) noexcept {
  switch (unknown) {
    case kOffset:
      return parts.offset;
    case kScale:
      return parts.scale;
    case kStrayI:
    case kStrayQ:
      return parts.stray;
    case kEmitterX:
    case kEmitterY:
      return parts.emitter;
    case kWallTurnX:
    case kWallTurnY:
      return parts.wall_turn;
    case kWallShift:
      return parts.shifted_wall != kNoWall;
    default:
      return parts.wiggling;
  }
}

Row row_of(const WallData& data, const FitParts& parts, const PmdModel& model,
           const Observation& o) {
  const double turn = model.scale * model.turn_m;
  const std::array<double, 3>& ray = data.rays[o.pixel];
  const double path = half_path(model.emitters, ray, distance_of(parts, model, ray, o));
  const double phi2 = (path - model.shift_m) / turn;
  const double phi1 = model.wiggling.inverse(phi2);
  const double theta = phi1 + model.offset + model.pattern[o.pixel];
  const std::complex<double> stray = model.phase_falls ? std::conj(model.stray) : model.stray;
  const std::complex<double> signal = o.iq - o.exposure * stray;
  const std::complex<double> back = std::polar(1.0, -kTurn * theta);
  const std::complex<double> seen = signal * back;
  const double sigma = o.sigma;
  Row row;
  // Im of the turned signal; an angle beyond a right one must not look like a small one.
  const double across = seen.real() > 0 ? seen.imag() : std::copysign(std::abs(seen), seen.imag());
  row.residual = across / sigma;
  const double size = std::abs(row.residual);
  row.weight = size <= kHuber ? 1 : kHuber / size;
  const double by_theta = -kTurn * std::max(seen.real(), 0.1 * std::abs(seen)) / sigma;
  const double gain = by_theta / (1 - model.wiggling.slope(phi1));
  row.by_pattern = by_theta;
  row.by[kOffset] = by_theta;
  row.by[kScale] = -gain * phi2 / model.scale;
  // d Im((M - S) back) = -Im(back) dS_i - Re(back) dS_q, S the conjugate where the phase falls.
  row.by[kStrayI] = -o.exposure * back.imag() / sigma;
  row.by[kStrayQ] = -o.exposure * back.real() / sigma * (model.phase_falls ? -1 : 1);
  if (parts.emitter) {
    emitter_columns(data, parts, model, o, gain / turn, row);
  }
  if (parts.wall_turn) {
    wall_turn_columns(data, parts, model, o, gain / turn, row);
  }
  if (o.wall == parts.shifted_wall) {
    row.by[kWallShift] = wall_shift_column(data, parts, model, o, gain / turn);
  }
  for (int h = 0; parts.wiggling && h < kHarmonics; ++h) {
    const std::complex<double> wave = std::polar(1.0, kTurn * (h + 1) * phi1);
    row.by[kFirstHarmonic + 2 * h] = gain * wave.real();
    row.by[kFirstHarmonic + 2 * h + 1] = gain * wave.imag();
  }
  return row;
}

double prior_of(int unknown) noexcept {
  if (unknown == kScale) {
    return 1 / (kScalePrior * kScalePrior);
  }
  return unknown >= kFirstHarmonic ? 1 / (kHarmonicPrior * kHarmonicPrior) : 0;
}

std::vector<Observation> observations(const WallData& data, bool phase_falls) {
  std::vector<Observation> seen;
  for (std::size_t p = 0; p < data.rays.size(); ++p) {
    const int x = static_cast<int>(p) % data.lens.width;
    const int y = static_cast<int>(p) / data.lens.width;
    const double forward = data.rays[p][2];
    const bool used = (x + 3 * y) % data.every == 0 && forward > 0;
    for (std::size_t w = 0; w < data.walls.size() && used; ++w) {
      const Wall& wall = data.walls[w];
      const Reading& reading = wall.readings[p];
      const std::complex<double> iq(reading.i, phase_falls ? -reading.q : reading.q);
      if (reading.saturated || std::abs(iq) < 2 * data.min_amplitude_lsb) {
        continue;
      }
      // I and Q are differences of two samples.
      seen.push_back(
          {.pixel = p,
           .wall = w,
           .iq = iq,
           .distance_m = wall.z_m / forward,
           .exposure = wall.exposure,
           .variance = 2 * data.noise.variance(reading.level, wall.exposure) / wall.frames});
    }
  }
  return seen;
}

}  // namespace stof::host
