#include "host/calibrate/rig/extrinsics/wall_plane.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "dsp/base/random.h"

namespace stof::host {
namespace {

constexpr int kTries = 200;  // of planes through three looks
constexpr std::size_t kAsked = 1000;
constexpr int kRounds = 6;            // of fits to those on the plane
constexpr double kOnPlane = 4;        // robust standard deviations
constexpr double kFirstShare = 0.02;  // of q: what counts as near a tried plane
constexpr double kLeastShare = 0.5;
constexpr double kSigmaOfMad = 1.4826;

double off(const PlaneLook& look, const Eigen::Vector3d& m) { return look.q - m.dot(look.ray); }

struct Sums {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  void add(const PlaneLook& look) {
    const double weight = 1 / (look.sigma * look.sigma);
    normal += weight * look.ray * look.ray.transpose();
    right += weight * look.q * look.ray;
  }
};

// The right side's change when readings at a knot are 1 m farther: q = 1 / d falls by q^2.
PerKnot right_per_knot(const std::vector<const PlaneLook*>& looks) {
  PerKnot sums = PerKnot::Zero();
  for (const PlaneLook* const look : looks) {
    const double place = std::clamp(1 / look->q / kRangeStepM - 1, 0.0, kRangeKnots - 1.0);
    const int knot = std::min(static_cast<int>(place), kRangeKnots - 2);
    const double part = place - knot;
    const Eigen::Vector3d change = -look->q * look->q / (look->sigma * look->sigma) * look->ray;
    sums.col(knot) += (1 - part) * change;
    sums.col(knot + 1) += part * change;
  }
  return sums;
}

// What errors that looks of like disparities share add to the covariance.
Eigen::Matrix3d shared_covariance(const std::vector<const PlaneLook*>& looks,
                                  const Eigen::Matrix3d& inverse) {
  std::map<int, Eigen::Vector3d> per_half_px;  // straight lines between
  for (const PlaneLook* const look : looks) {
    if (look->disparity_px == 0) {
      continue;
    }
    const double place = 2 * look->disparity_px;
    const int half = static_cast<int>(std::floor(place));
    const double part = place - half;
    const Eigen::Vector3d change = kSharedPx / look->sigma * look->ray;
    for (const auto& [at, weight] : {std::pair(half, 1 - part), std::pair(half + 1, part)}) {
      per_half_px.try_emplace(at, Eigen::Vector3d::Zero()).first->second += weight * change;
    }
  }
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [at, change] : per_half_px) {
    sum += (inverse * change) * (inverse * change).transpose();
  }
  return sum;
}

Sums sums_of(const std::vector<const PlaneLook*>& looks) {
  Sums sums;
  for (const PlaneLook* const look : looks) {
    sums.add(*look);
  }
  return sums;
}

std::vector<const PlaneLook*> near(const std::vector<PlaneLook>& looks, const Eigen::Vector3d& m,
                                   double sigmas) {
  std::vector<const PlaneLook*> found;
  for (const PlaneLook& look : looks) {
    if (std::abs(off(look, m)) <= sigmas * look.sigma) {
      found.push_back(&look);
    }
  }
  return found;
}

// Of about a thousand of the looks.
std::size_t support_of(const std::vector<PlaneLook>& looks, const Eigen::Vector3d& m) {
  const std::size_t step = std::max<std::size_t>(1, looks.size() / kAsked);
  std::size_t support = 0;
  for (std::size_t i = 0; i < looks.size(); i += step) {
    if (std::abs(off(looks[i], m)) <= kFirstShare * looks[i].q) {
      ++support;
    }
  }
  return support;
}

// Of planes through three looks the one with most support.
Eigen::Vector3d tried(const std::vector<PlaneLook>& looks) {
  dsp::SplitMix64 random(looks.size());
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  std::size_t most = 0;
  for (int n = 0; n < kTries; ++n) {
    Eigen::Matrix3d rays;
    Eigen::Vector3d q;
    for (int k = 0; k < 3; ++k) {
      const PlaneLook& look = looks[random.next() % looks.size()];
      rays.row(k) = look.ray.transpose();
      q(k) = look.q;
    }
    const Eigen::Vector3d m = rays.fullPivLu().solve(q);
    const std::size_t support = m.allFinite() ? support_of(looks, m) : 0;
    if (support > most) {
      most = support;
      best = m;
    }
  }
  return best;
}

}  // namespace

std::optional<SeenPlane> plane_of(const std::vector<PlaneLook>& looks, bool ranges) {
  if (looks.size() < kFewestLooks) {
    return std::nullopt;
  }
  Eigen::Vector3d m = tried(looks);
  // The scale of the sigmas is found with the plane: from the looks that support it.
  double scale = 0;
  std::vector<const PlaneLook*> on;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> offs;
    for (const PlaneLook& look : looks) {
      if (round > 0 || std::abs(off(look, m)) <= kFirstShare * look.q) {
        offs.push_back(std::abs(off(look, m)) / look.sigma);
      }
    }
    if (offs.size() < kFewestLooks) {
      return std::nullopt;
    }
    const auto middle = offs.begin() + static_cast<std::ptrdiff_t>(offs.size() / 2);
    std::ranges::nth_element(offs, middle);
    scale = kSigmaOfMad * *middle;
    on = near(looks, m, kOnPlane * scale);
    const Sums sums = sums_of(on);
    m = sums.normal.ldlt().solve(sums.right);
  }
  const double share = static_cast<double>(on.size()) / static_cast<double>(looks.size());
  if (on.size() < kFewestLooks || share < kLeastShare || !m.allFinite()) {
    return std::nullopt;
  }
  double squares = 0;
  for (const PlaneLook* const look : on) {
    squares += std::pow(off(*look, m) / look->sigma, 2);
  }
  const double variance = squares / static_cast<double>(on.size() - 3);
  const Sums sums = sums_of(on);
  const Eigen::Matrix3d inverse = sums.normal.inverse();
  return SeenPlane{
      .m = m,
      .covariance = variance * inverse + shared_covariance(on, inverse),
      .per_knot = ranges ? PerKnot(inverse * right_per_knot(on)) : PerKnot(PerKnot::Zero()),
      .share = share,
      .misfit = std::sqrt(variance)};
}

}  // namespace stof::host
