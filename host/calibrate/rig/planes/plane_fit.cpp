#include "host/calibrate/rig/planes/plane_fit.h"

#include <cmath>
#include <numbers>
#include <numeric>

#include <ceres/ceres.h>

#include "host/calibrate/rig/fit_covariance.h"

namespace stof::host {
namespace {

constexpr std::size_t kWallUnknowns = 3;  // nearer or farther, m; slopes along columns and rows
using Wall = std::array<double, kWallUnknowns>;
constexpr double kHuberSigmas = 3;
constexpr double kFirstCellSigmaPx = 0.1;
constexpr int kRounds = 4;

// What a matcher is off by is not each cell's own. Fractions of a pixel are drawn to whole and half
// ones, by as much for all cells of one fraction, and cells of a wall differ by few pixels: waves
// of the disparity. Lenses that bend and texture that is seen foreshortened make the walls'
// disparities look curved along columns, from which a focal length and the baseline would seem to
// follow.
constexpr std::size_t kPulls = 5;  // sine and cosine of the disparity's turn and of two; curvature
using Pulls = std::array<double, kPulls>;
constexpr Pulls kPullSigmaPx{0.1, 0.03, 0.03, 0.03, 0.02};
// By how much each differs between walls, whose texture looks finer from farther away.
constexpr double kPullSpreadPx = 0.01;

// column: -1 to 1 over the part of the picture that is matched.
Pulls waves_of(double disparity, double column) {
  const double turn = 2 * std::numbers::pi * disparity;
  return {std::sin(turn), std::cos(turn), std::sin(2 * turn), std::cos(2 * turn), column * column};
}

// Of a cell's disparity without what was found of its pull before.
Pulls waves_of(const PlaneCell& cell, const PlaneSensor& sensor, const Pulls& before) {
  const double half = (1 + sensor.cx_left) * PlaneOptions{}.middle;
  const double column = (cell.left - sensor.cx_left) / half;
  const double found = cell.left - cell.right;
  const Pulls waves = waves_of(found, column);
  const double pulled = std::inner_product(waves.begin(), waves.end(), before.begin(), 0.0);
  return waves_of(found - pulled, column);
}

// The disparity that a cell has more than the wall says, in standard deviations.
struct CellResidual {
  double left_m;
  double right_m;
  double row_m;
  double z_m;
  double pixel_m;
  double sigma_px;
  Pulls waves;

  template <typename T>
  bool operator()(const T* x, const T* wall, const T* pulls, T* residual) const {
    using std::tan;
    const T left = tangent_of(tan(x[2]), T(-left_m) / x[4]);
    // X = -left Z, Y = row_m / f2 Z; the wall is Z = z + s_x X + s_y Y.
    const T inverse_z = (T(1) + wall[1] * left - wall[2] * (T(row_m) / x[4])) / (T(z_m) + wall[0]);
    const T parallax = tangent_of(tan(x[1]), T(-right_m) / x[3]) - left;
    T off = (parallax - x[0] * inverse_z) * x[3] / T(pixel_m);
    for (std::size_t i = 0; i < kPulls; ++i) {
      off -= waves[i] * pulls[i];
    }
    residual[0] = off / T(sigma_px);
    return true;
  }
};

struct Priors {
  PlanePriors told;

  template <typename T>
  bool operator()(const T* x, T* residual) const {
    residual[0] = (x[0] - T(told.baseline_m)) / T(told.baseline_sigma_m);
    residual[1] = ((x[3] + x[4]) / T(2 * told.focal_m) - T(1)) / T(told.focal_sigma);
    residual[2] = (x[3] - x[4]) / T(told.focal_m * told.focal_difference);
    residual[3] = (x[1] + x[2]) / T(2 * told.pointing_sigma_rad);
    return true;
  }
};

struct WallPrior {
  PlanePriors told;

  template <typename T>
  bool operator()(const T* wall, T* residual) const {
    residual[0] = wall[0] / T(told.distance_sigma_m);
    residual[1] = wall[1] / T(told.tilt_sigma_rad);
    residual[2] = wall[2] / T(told.tilt_sigma_rad);
    return true;
  }
};

struct PullPrior {
  template <typename T>
  bool operator()(const T* pulls, T* residual) const {
    for (std::size_t i = 0; i < kPulls; ++i) {
      residual[i] = pulls[i] / T(kPullSigmaPx[i]);
    }
    return true;
  }
};

struct PullSpread {
  template <typename T>
  bool operator()(const T* all, const T* wall, T* residual) const {
    for (std::size_t i = 0; i < kPulls; ++i) {
      residual[i] = (wall[i] - all[i]) / T(kPullSpreadPx);
    }
    return true;
  }
};

class PlaneProblem {
 public:
  PlaneProblem(const std::vector<Plane>& planes, const PlaneSensor& sensor,
               const PlanePriors& priors, const PlaneUnknowns& start, double sigma_px,
               const std::vector<Pulls>& pulls)
      : x_(start), walls_(planes.size()), pulls_(pulls) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Priors, 4, int{kPlaneUnknowns}>(new Priors{priors}),
        nullptr, x_.data());
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PullPrior, int{kPulls}, int{kPulls}>(new PullPrior),
        nullptr, all_pulls_.data());
    for (std::size_t n = 0; n < planes.size(); ++n) {
      double* const wall = walls_[n].data();
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<WallPrior, 3, int{kWallUnknowns}>(new WallPrior{priors}),
          nullptr, wall);
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PullSpread, int{kPulls}, int{kPulls}, int{kPulls}>(
              new PullSpread),
          nullptr, all_pulls_.data(), pulls_[n].data());
      for (const PlaneCell& cell : planes[n].cells) {
        cells_.push_back(problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<CellResidual, 1, int{kPlaneUnknowns},
                                            int{kWallUnknowns}, int{kPulls}>(new CellResidual{
                sensor.left_m(cell), sensor.right_m(cell), (cell.row - sensor.cy) * sensor.pixel_m,
                planes[n].z_m, sensor.pixel_m, sigma_px, waves_of(cell, sensor, pulls_[n])}),
            new ceres::HuberLoss(kHuberSigmas), x_.data(), wall, pulls_[n].data()));
      }
    }
  }

  bool solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  const PlaneUnknowns& x() const { return x_; }
  const std::vector<Pulls>& pulls() const { return pulls_; }

  // Of the cells alone, in standard deviations.
  double rms() {
    ceres::Problem::EvaluateOptions options;
    options.residual_blocks = cells_;
    options.apply_loss_function = false;
    double cost = 0;
    problem_.Evaluate(options, &cost, nullptr, nullptr, nullptr);
    return std::sqrt(2 * cost / static_cast<double>(cells_.size()));
  }

  // Of all unknowns, x first.
  std::optional<Eigen::MatrixXd> covariance() {
    std::vector<double*> unknowns{x_.data()};
    for (Wall& wall : walls_) {
      unknowns.push_back(wall.data());
    }
    for (Pulls& pulls : pulls_) {
      unknowns.push_back(pulls.data());
    }
    unknowns.push_back(all_pulls_.data());
    return fit_covariance(problem_, unknowns);
  }

 private:
  PlaneUnknowns x_;
  std::vector<Wall> walls_;
  std::vector<Pulls> pulls_;
  Pulls all_pulls_{};
  ceres::Problem problem_;
  std::vector<ceres::ResidualBlockId> cells_;
};

using Gradient = Eigen::Matrix<double, int{kPlaneUnknowns}, 1>;

// Of triangulation_constant(), by differences.
Gradient constant_gradient(const PlaneUnknowns& x) {
  Gradient gradient;
  for (std::size_t i = 0; i < kPlaneUnknowns; ++i) {
    const double step = 1e-6 * std::max(std::abs(x[i]), 1e-3);
    PlaneUnknowns more = x;
    PlaneUnknowns less = x;
    more[i] += step;
    less[i] -= step;
    gradient(static_cast<Eigen::Index>(i)) =
        (triangulation_constant(more) - triangulation_constant(less)) / (2 * step);
  }
  return gradient;
}

}  // namespace

std::optional<PlaneFit> refine(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                               const PlanePriors& priors, const PlaneUnknowns& start) {
  PlaneFit fit;
  fit.x = start;
  fit.cell_sigma_px = kFirstCellSigmaPx;
  std::optional<Eigen::MatrixXd> covariance;
  std::vector<Pulls> pulls(planes.size());
  // How far cells scatter weighs them against the priors.
  for (int round = 0; round < kRounds; ++round) {
    PlaneProblem problem(planes, sensor, priors, fit.x, fit.cell_sigma_px, pulls);
    if (!problem.solve()) {
      return std::nullopt;
    }
    fit.x = problem.x();
    pulls = problem.pulls();
    covariance = problem.covariance();
    fit.cell_sigma_px *= problem.rms();
  }
  if (!covariance) {
    return std::nullopt;
  }
  fit.covariance = covariance->topLeftCorner<int{kPlaneUnknowns}, int{kPlaneUnknowns}>();
  const double half_difference = priors.focal_difference / 2;
  const double focal = priors.focal_m * std::hypot(priors.focal_sigma, half_difference);
  fit.from_prior = {priors.baseline_sigma_m, HUGE_VAL, HUGE_VAL, focal, focal};
  const Gradient constant = constant_gradient(fit.x);
  fit.constant_sigma = std::sqrt(constant.dot(fit.covariance * constant));
  Gradient difference = Gradient::Zero();
  difference(1) = 1;
  difference(2) = -1;
  fit.difference_sigma = std::sqrt(difference.dot(fit.covariance * difference));
  return fit;
}

}  // namespace stof::host
