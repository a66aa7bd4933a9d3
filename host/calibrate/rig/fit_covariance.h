#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <ceres/problem.h>

namespace stof::host {

// The covariance of what was fitted: the inverse of its normal equations, where residuals are in
// standard deviations; else that per variance of a residual. Every residual counts in full,
// whatever loss function it has. unknowns: the problem's parameter blocks, in the order of the
// rows; a block with a manifold has as many rows as that is wide. None where the residuals cannot
// tell the unknowns apart.
std::optional<Eigen::MatrixXd> fit_covariance(ceres::Problem& problem,
                                              const std::vector<double*>& unknowns);

// J^T J and J^T r of some of its residual blocks, in whose standard deviations they are; every
// residual counts in full.
struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
};
std::optional<NormalEquations> normal_equations(
    ceres::Problem& problem, const std::vector<ceres::ResidualBlockId>& residuals,
    const std::vector<double*>& unknowns);

}  // namespace stof::host
