#include "host/calibrate/fit/pmd_noise.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Dense>

namespace stof::host {
namespace {

constexpr double kRounding = 1.0 / 12;
constexpr int kRounds = 6;
constexpr double kOutlier = 6;            // standard deviations of a variance
constexpr double kSignificantSigmas = 3;  // standard deviations of a coefficient

// variance = x[0] level + x[1] + x[2] exposure.
struct Variance {
  Eigen::Vector3d x = Eigen::Vector3d(0, 1, 0);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool known = false;

  double at(double level, double exposure) const {
    return std::max(x[0] * std::max(level, 0.0) + x[1] + x[2] * exposure, kRounding);
  }
};

// Four sample variances over n frames have a relative variance of 2 / (4 (n - 1)).
double relative_variance(const Wall& wall) { return 0.5 / (wall.frames - 1); }

Variance fit(std::span<const Wall> walls, bool suppressed) {
  Variance found;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Wall& wall : walls) {
      for (const Reading& reading : wall.readings) {
        if (reading.saturated || wall.frames < 2) {
          continue;
        }
        const double expected = round == 0 ? 1 : found.at(reading.level, wall.exposure);
        const double sd = expected * std::sqrt(relative_variance(wall));
        if (round > 1 && std::abs(reading.spread - expected) > kOutlier * sd) {
          continue;
        }
        const Eigen::Vector3d row(reading.level, 1, suppressed ? wall.exposure : 0);
        normal += row * row.transpose() / (sd * sd);
        right += row * reading.spread / (sd * sd);
      }
    }
    if (!suppressed) {
      normal(2, 2) = 1;
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
    if (normal(0, 0) <= 0 || solver.rcond() < 1e-14) {
      return {};
    }
    found.x = solver.solve(right);
    found.covariance = solver.solve(Eigen::Matrix3d::Identity());
  }
  found.known = found.x[0] > kSignificantSigmas * std::sqrt(found.covariance(0, 0));
  return found;
}

bool exposures_differ(std::span<const Wall> walls) {
  return std::ranges::any_of(walls,
                             [&](const Wall& wall) { return wall.exposure != walls[0].exposure; });
}

}  // namespace

double SampleNoise::variance(double level, double exposure) const noexcept {
  const double light = std::max(level, 0.0) + suppressed_lsb * exposure;
  return light / electrons_per_lsb + noise_lsb * noise_lsb + kRounding;
}

std::optional<SampleNoise> fit_noise(std::span<const Wall> walls, const SampleNoise& before) {
  if (walls.empty()) {
    return std::nullopt;
  }
  Variance found;
  bool separate = exposures_differ(walls);
  if (separate) {
    found = fit(walls, true);
    separate = found.known && found.x[1] > kRounding &&
               found.x[2] > kSignificantSigmas * std::sqrt(found.covariance(2, 2));
  }
  if (!separate) {
    found = fit(walls, false);
  }
  if (!found.known) {
    return std::nullopt;
  }
  SampleNoise noise{.electrons_per_lsb = 1 / found.x[0], .noise_lsb = 0, .suppressed_lsb = 0};
  noise.suppressed_lsb = separate ? found.x[2] / found.x[0] : before.suppressed_lsb;
  const double shared = separate ? 0 : noise.suppressed_lsb * found.x[0];
  noise.noise_lsb = std::sqrt(std::max(found.x[1] - shared - kRounding, 0.0));
  return noise;
}

std::optional<dsp::SigmaPolynomial> fit_sigma(std::span<const SigmaPoint> points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::set<double> distances;
  for (const SigmaPoint& point : points) {
    const double z = point.z_m * 100;
    const double sigma = point.sigma_m * 100;
    if (!(sigma > 0)) {
      continue;
    }
    distances.insert(z);
    const Eigen::Vector3d row = Eigen::Vector3d(1, z, z * z) / sigma;
    normal += row * row.transpose();
    right += row;
  }
  // In units in which all three are alike, so that rank can be judged.
  const Eigen::Vector3d unit = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(unit.asDiagonal() * normal * unit.asDiagonal());
  if (distances.size() < 3 || solver.rcond() < 1e-12) {
    return std::nullopt;
  }
  const Eigen::Vector3d x = unit.asDiagonal() * solver.solve(unit.asDiagonal() * right);
  return dsp::SigmaPolynomial{.a = x[0], .b = x[1], .c = x[2]};
}

double sigma_at(const dsp::SigmaPolynomial& polynomial, double z_m) noexcept {
  const double z = z_m * 100;
  return (polynomial.a + z * (polynomial.b + z * polynomial.c)) / 100;
}

}  // namespace stof::host
