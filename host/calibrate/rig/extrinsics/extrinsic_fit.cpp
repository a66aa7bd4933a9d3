#include "host/calibrate/rig/extrinsics/extrinsic_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "host/calibrate/rig/fit_covariance.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using Wall = std::array<double, 3>;

constexpr std::size_t kFewestWalls = 3;
constexpr double kLeastSideways = 0.35;  // between the outermost tilts, rad: 20 degrees
constexpr double kLeastUpwards = 0.35;
constexpr double kMisfitOfChance = 2;  // 3 standard deviations for 8 walls
// The smallest eigenvalue of the sum of n n^T a wall, below which T is not told in one direction.
constexpr double kLeastSpread = 0.01;

Eigen::Matrix3d whitener(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d lower = covariance.llt().matrixL();
  return lower.inverse();
}

struct StereoResidual {
  Eigen::Vector3d seen;
  Eigen::Matrix3d white;

  template <typename T>
  bool operator()(const T* wall, T* residual) const {
    for (int i = 0; i < 3; ++i) {
      residual[i] = T(0);
      for (int k = 0; k < 3; ++k) {
        residual[i] += white(i, k) * (seen(k) - wall[k]);
      }
    }
    return true;
  }
};

struct PmdResidual {
  Eigen::Vector3d seen;
  PerKnot per_knot;
  Eigen::Matrix3d white;
  Eigen::Matrix3d start;  // of the rotation; the unknown is a small turn behind it

  template <typename T>
  bool operator()(const T* pose, const T* offset, const T* leftover, const T* wall,
                  T* residual) const {
    // m_p = R^T m_s / (1 - m_s . T)
    const T back[3] = {-pose[0], -pose[1], -pose[2]};
    T turned[3];
    ceres::AngleAxisRotatePoint(back, wall, turned);
    const T scale = T(1) - (wall[0] * pose[3] + wall[1] * pose[4] + wall[2] * pose[5]);
    T off[3];
    for (int k = 0; k < 3; ++k) {
      off[k] =
          seen(k) -
          (start(0, k) * turned[0] + start(1, k) * turned[1] + start(2, k) * turned[2]) / scale;
      for (int knot = 0; knot < kRangeKnots; ++knot) {
        off[k] -= per_knot(k, knot) * (offset[0] + leftover[knot]);
      }
    }
    for (int i = 0; i < 3; ++i) {
      residual[i] = white(i, 0) * off[0] + white(i, 1) * off[1] + white(i, 2) * off[2];
    }
    return true;
  }
};

// Of so many unknowns around 0.
template <int kCount>
struct Prior {
  double sigma_m;
  template <typename T>
  bool operator()(const T* unknown, T* residual) const {
    for (int k = 0; k < kCount; ++k) {
      residual[k] = unknown[k] / T(sigma_m);
    }
    return true;
  }
};

// The rotation between normals (Kabsch), and T by least squares.
std::optional<PoseUnknowns> start_of(const std::vector<SeenWall>& walls) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (const SeenWall& wall : walls) {
    correlation += wall.stereo.m.normalized() * wall.pmd.m.normalized().transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d sign = Eigen::Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d turn = svd.matrixU() * sign * svd.matrixV().transpose();
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const SeenWall& wall : walls) {
    const Eigen::Vector3d n = wall.stereo.m.normalized();
    normal += n * n.transpose();
    right += n * (1 / wall.stereo.m.norm() - 1 / wall.pmd.m.norm());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(normal);
  if (spread.eigenvalues()(0) < kLeastSpread * static_cast<double>(walls.size())) {
    return std::nullopt;
  }
  return pose_of(turn, Vector3(normal.ldlt().solve(right)));
}

class ExtrinsicProblem {
 public:
  ExtrinsicProblem(const std::vector<SeenWall>& walls, const ExtrinsicOptions& options,
                   const PoseUnknowns& start)
      : seen_(walls),
        options_(options),
        start_(rotation_of(start)),
        pose_{0, 0, 0, start[3], start[4], start[5]} {
    for (const SeenWall& wall : walls) {
      walls_.push_back({wall.stereo.m.x(), wall.stereo.m.y(), wall.stereo.m.z()});
    }
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Prior<1>, 1, 1>(new Prior<1>{options.offset_sigma_m}),
        nullptr, &offset_);
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Prior<kRangeKnots>, kRangeKnots, kRangeKnots>(
            new Prior<kRangeKnots>{options.leftover_sigma_m}),
        nullptr, leftover_.data());
    for (std::size_t n = 0; n < walls.size(); ++n) {
      const SeenWall& wall = walls[n];
      blocks_.push_back(
          {problem_.AddResidualBlock(
               new ceres::AutoDiffCostFunction<StereoResidual, 3, 3>(
                   new StereoResidual{wall.stereo.m, whitener(wall.stereo.covariance)}),
               nullptr, walls_[n].data()),
           problem_.AddResidualBlock(
               new ceres::AutoDiffCostFunction<PmdResidual, 3, 6, 1, kRangeKnots, 3>(
                   new PmdResidual{wall.pmd.m, wall.pmd.per_knot, whitener(wall.pmd.covariance),
                                   start_}),
               nullptr, pose_.data(), &offset_, leftover_.data(), walls_[n].data())});
    }
  }

  bool solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-14;
    options.parameter_tolerance = 1e-14;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  bool put(ExtrinsicFit& fit) {
    const PoseUnknowns small{pose_[0], pose_[1], pose_[2], 0, 0, 0};
    fit.pmd_to_stereo =
        pose_of(Matrix3(rotation_of(small) * start_), Vector3(pose_[3], pose_[4], pose_[5]));
    fit.offset_m = offset_;
    double chi2 = 0;
    for (const std::array<ceres::ResidualBlockId, 2>& wall : blocks_) {
      const double of_wall = cost_of(wall);
      fit.wall_misfit.push_back(std::sqrt(of_wall / 3));
      chi2 += of_wall;
    }
    chi2 += std::pow(offset_ / options_.offset_sigma_m, 2);
    for (const double leftover : leftover_) {
      chi2 += std::pow(leftover / options_.leftover_sigma_m, 2);
    }
    const auto freedom = static_cast<double>(3 * blocks_.size()) - 6;
    fit.misfit = freedom > 0 ? chi2 / freedom : 0;
    put_gaps(fit);
    if (!put_covariance(fit)) {
      return false;
    }
    // Looks of a wall share errors that their scatter does not show: of the pair, of the PMD
    // camera.
    if (fit.misfit > kMisfitOfChance) {
      fit.covariance *= fit.misfit;
      fit.offset_sigma_m *= std::sqrt(fit.misfit);
    }
    return true;
  }

 private:
  // At each knot.
  Eigen::Matrix<double, kRangeKnots, 1> too_far() const {
    return Eigen::Map<const Eigen::Matrix<double, kRangeKnots, 1>>(leftover_.data()).array() +
           offset_;
  }

  void put_gaps(ExtrinsicFit& fit) const {
    const Matrix3 turn = rotation_of(fit.pmd_to_stereo);
    const Vector3 shift = translation_of(fit.pmd_to_stereo);
    double turned = 0;
    double apart = 0;
    for (const SeenWall& wall : seen_) {
      const Vector3 expected = turn.transpose() * wall.stereo.m / (1 - wall.stereo.m.dot(shift));
      const Vector3 found = wall.pmd.m - wall.pmd.per_knot * too_far();
      turned += std::pow(std::atan2(expected.cross(found).norm(), expected.dot(found)), 2);
      apart += std::pow(1 / expected.z() - 1 / found.z(), 2);
    }
    fit.turned_rad = std::sqrt(turned / static_cast<double>(seen_.size()));
    fit.apart_m = std::sqrt(apart / static_cast<double>(seen_.size()));
  }

  double cost_of(const std::array<ceres::ResidualBlockId, 2>& wall) {
    ceres::Problem::EvaluateOptions options;
    options.residual_blocks = {wall[0], wall[1]};
    double cost = 0;
    problem_.Evaluate(options, &cost, nullptr, nullptr, nullptr);
    return 2 * cost;
  }

  bool put_covariance(ExtrinsicFit& fit) {
    std::vector<double*> unknowns{pose_.data(), &offset_, leftover_.data()};
    for (Wall& wall : walls_) {
      unknowns.push_back(wall.data());
    }
    const std::optional<Eigen::MatrixXd> covariance = fit_covariance(problem_, unknowns);
    if (covariance) {
      fit.covariance = covariance->topLeftCorner<6, 6>();
      fit.offset_sigma_m = std::sqrt((*covariance)(6, 6));
    }
    return covariance.has_value();
  }

  const std::vector<SeenWall>& seen_;
  ExtrinsicOptions options_;
  Matrix3 start_;
  PoseUnknowns pose_;
  double offset_ = 0;
  std::array<double, kRangeKnots> leftover_{};
  std::vector<Wall> walls_;
  ceres::Problem problem_;
  std::vector<std::array<ceres::ResidualBlockId, 2>> blocks_;
};

}  // namespace

std::optional<ExtrinsicFit> fit_extrinsics(const std::vector<SeenWall>& walls,
                                           const ExtrinsicOptions& options) {
  const std::optional<PoseUnknowns> start =
      walls.size() < kFewestWalls ? std::nullopt : start_of(walls);
  if (!start) {
    return std::nullopt;
  }
  ExtrinsicProblem problem(walls, options, *start);
  ExtrinsicFit fit;
  if (!problem.solve() || !problem.put(fit)) {
    return std::nullopt;
  }
  return fit;
}

std::string ExtrinsicFit::contradiction() const {
  if (misfit <= kMisfitOfChance || (turned_rad <= kLargestTurnedRad && apart_m <= kLargestApartM)) {
    return {};
  }
  return printed(
      "the sensors see these walls %.1f degrees and %.0f mm apart (%.1f and %.0f are allowed)",
      turned_rad * kDegrees, apart_m * kMm, kLargestTurnedRad * kDegrees, kLargestApartM * kMm);
}

std::vector<std::string> missing_tilts(const std::vector<SeenWall>& walls) {
  std::vector<std::string> missing;
  if (walls.size() < kFewestWalls + 2) {
    missing.push_back(printed("more: %zu walls, 5 are needed", walls.size()));
  }
  double left = HUGE_VAL, right = -HUGE_VAL, up = HUGE_VAL, down = -HUGE_VAL;
  for (const SeenWall& wall : walls) {
    const Eigen::Vector3d& m = wall.stereo.m;
    const double sideways = std::atan2(m.x(), m.z());
    const double upwards = std::atan2(m.y(), m.z());
    left = std::min(left, sideways);
    right = std::max(right, sideways);
    up = std::min(up, upwards);
    down = std::max(down, upwards);
  }
  if (!(right - left >= kLeastSideways)) {
    missing.emplace_back(
        "tilted: no two walls are turned sideways against each other by 20 degrees");
  }
  if (!(down - up >= kLeastUpwards)) {
    missing.emplace_back(
        "tilted: no two walls are tilted up and down against each other by 20 degrees");
  }
  return missing;
}

Eigen::Matrix<double, 6, 1> difference(const PoseUnknowns& fit, const PoseUnknowns& truth) {
  const PoseUnknowns turn =
      pose_of(Matrix3(rotation_of(truth) * rotation_of(fit).transpose()), Vector3::Zero());
  Eigen::Matrix<double, 6, 1> off;
  off << turn[0], turn[1], turn[2], truth[3] - fit[3], truth[4] - fit[4], truth[5] - fit[5];
  return off;
}

}  // namespace stof::host
