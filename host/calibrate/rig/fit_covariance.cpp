#include "host/calibrate/rig/fit_covariance.h"

#include <Eigen/Eigenvalues>
#include <ceres/crs_matrix.h>

#include "dsp/base/index.h"

namespace stof::host {
namespace {

using dsp::index;

constexpr double kLargestCondition = 1e14;  // of the scaled normal equations

Eigen::MatrixXd normal_equations(const ceres::CRSMatrix& jacobian) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(jacobian.num_cols, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int a = jacobian.rows[index(row)]; a < jacobian.rows[index(row) + 1]; ++a) {
      for (int b = jacobian.rows[index(row)]; b < jacobian.rows[index(row) + 1]; ++b) {
        normal(jacobian.cols[index(a)], jacobian.cols[index(b)]) +=
            jacobian.values[index(a)] * jacobian.values[index(b)];
      }
    }
  }
  return normal;
}

}  // namespace

std::optional<NormalEquations> normal_equations(
    ceres::Problem& problem, const std::vector<ceres::ResidualBlockId>& residuals,
    const std::vector<double*>& unknowns) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  options.residual_blocks = residuals;
  options.parameter_blocks = unknowns;
  std::vector<double> off;
  ceres::CRSMatrix jacobian;
  if (!problem.Evaluate(options, nullptr, &off, nullptr, &jacobian)) {
    return std::nullopt;
  }
  NormalEquations made{.matrix = normal_equations(jacobian),
                       .right = Eigen::VectorXd::Zero(jacobian.num_cols)};
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int a = jacobian.rows[index(row)]; a < jacobian.rows[index(row) + 1]; ++a) {
      made.right(jacobian.cols[index(a)]) += jacobian.values[index(a)] * off[index(row)];
    }
  }
  return made;
}

std::optional<Eigen::MatrixXd> fit_covariance(ceres::Problem& problem,
                                              const std::vector<double*>& unknowns) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  options.parameter_blocks = unknowns;
  ceres::CRSMatrix jacobian;
  if (!problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) {
    return std::nullopt;
  }
  const Eigen::MatrixXd normal = normal_equations(jacobian);
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) {
    return std::nullopt;  // nothing depends on one of the unknowns
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * normal *
                                                              scale.asDiagonal());
  const Eigen::VectorXd& values = solver.eigenvalues();
  if (!(values(0) * kLargestCondition > values(values.size() - 1))) {
    return std::nullopt;
  }
  const Eigen::MatrixXd inverse = solver.eigenvectors() * values.cwiseInverse().asDiagonal() *
                                  solver.eigenvectors().transpose();
  return Eigen::MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

}  // namespace stof::host
