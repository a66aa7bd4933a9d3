#include "host/calibrate/rig/target/pair_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Cholesky>
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "host/calibrate/rig/fit_covariance.h"
#include "host/calibrate/rig/target/board_pose.h"
#include "host/calibrate/rig/target/corner_whitening.h"

namespace stof::host {
namespace {

// A corner that is off by more counts less: finders sometimes take the wrong one.
constexpr double kHuberPx = 1;
constexpr int kMostSteps = 200;
// What lens, print and flatness leave of a corner: no grey values make one worth more than this.
constexpr double kLeastSigmaPx = 0.02;

// Of a coordinate of a corner, px^2.
double variance_of(const PixelPoint& corner) {
  return (corner.uu + corner.vv) / 2 + kLeastSigmaPx * kLeastSigmaPx;
}

// The median of all that are seen: what a corner is measured against.
double usual_variance(const std::vector<PairView>& views) {
  std::vector<double> each;
  for (const PairView& view : views) {
    for (const std::vector<PixelPoint>* const eye : {&view.left, &view.right}) {
      for (const PixelPoint& corner : *eye) {
        if (corner.seen()) {
          each.push_back(variance_of(corner));
        }
      }
    }
  }
  if (each.empty()) {
    return 1;
  }
  const auto middle = each.begin() + static_cast<std::ptrdiff_t>(each.size() / 2);
  std::ranges::nth_element(each, middle);
  return *middle;
}

// What a corner is off becomes what a usual corner would be that is as unlikely.
Whitening whitening_of(const PixelPoint& corner, double usual) {
  return whitening_of(corner, 1 / usual, kLeastSigmaPx * kLeastSigmaPx / usual);
}

template <typename T>
std::array<T, 3> moved(const T* pose, const std::array<T, 3>& point) {
  std::array<T, 3> turned;
  ceres::AngleAxisRotatePoint(pose, point.data(), turned.data());
  return {turned[0] + pose[3], turned[1] + pose[4], turned[2] + pose[5]};
}

// All corners of one picture would be one block; a corner each keeps the autodiff short.
struct LeftCorner {
  std::array<double, 2> on_board;
  PixelPoint found;
  Whitening whitening{};

  template <typename T>
  bool operator()(const T* lens, const T* board, T* residual) const {
    const std::array<T, 3> point = moved(board, {T(on_board[0]), T(on_board[1]), T(0)});
    std::array<T, 2> pixel;
    if (!project(lens, point, pixel)) {
      return false;
    }
    residual[0] = found.u - pixel[0];
    residual[1] = found.v - pixel[1];
    whitening.apply(residual);
    return true;
  }
};

struct RightCorner {
  std::array<double, 2> on_board;
  PixelPoint found;
  Whitening whitening{};

  template <typename T>
  bool operator()(const T* lens, const T* left_to_right, const T* board, T* residual) const {
    const std::array<T, 3> point =
        moved(left_to_right, moved(board, {T(on_board[0]), T(on_board[1]), T(0)}));
    std::array<T, 2> pixel;
    if (!project(lens, point, pixel)) {
      return false;
    }
    residual[0] = found.u - pixel[0];
    residual[1] = found.v - pixel[1];
    whitening.apply(residual);
    return true;
  }
};

class Stopper : public ceres::IterationCallback {
 public:
  explicit Stopper(const std::function<bool()>& stop) : stop_(stop) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& /*summary*/) override {
    return stop_ && stop_() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::function<bool()>& stop_;
};

struct Unknowns {
  LensUnknowns left;
  LensUnknowns right;
  PoseUnknowns left_to_right;
  std::vector<PoseUnknowns> boards;
};

class PairProblem {
 public:
  PairProblem(const Board& board, const std::vector<PairView>& views, Unknowns start,
              const PairFitOptions& options)
      : unknowns_(std::move(start)), usual_(usual_variance(views)) {
    for (LensUnknowns* const lens : {&unknowns_.left, &unknowns_.right}) {
      problem_.AddParameterBlock(lens->data(), int{kLensUnknowns});
      hold(*lens, options);
    }
    problem_.AddParameterBlock(unknowns_.left_to_right.data(), int{kPoseUnknowns});
    for (std::size_t n = 0; n < views.size(); ++n) {
      add(board, views[n], unknowns_.boards[n]);
    }
  }

  bool solve(const std::function<bool()>& stop) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = kMostSteps;
    options.function_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    options.gradient_tolerance = 1e-12;
    options.logging_type = ceres::SILENT;
    for (PoseUnknowns& pose : unknowns_.boards) {
      order_->AddElementToGroup(pose.data(), 0);
    }
    for (double* const block :
         {unknowns_.left.data(), unknowns_.right.data(), unknowns_.left_to_right.data()}) {
      order_->AddElementToGroup(block, 1);
    }
    options.linear_solver_ordering = order_;
    Stopper stopper(stop);
    options.callbacks.push_back(&stopper);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  const Unknowns& unknowns() const { return unknowns_; }

  // Of the rig's unknowns, then the boards', per variance of a coordinate. None: singular.
  std::optional<Eigen::MatrixXd> covariance() { return fit_covariance(problem_, blocks()); }

  // Of all unknowns, those that were held too. The problem holds none from then on.
  std::optional<NormalEquations> equations_of_all() {
    for (LensUnknowns* const lens : {&unknowns_.left, &unknowns_.right}) {
      problem_.SetManifold(lens->data(), nullptr);
    }
    return normal_equations(problem_, {}, blocks());
  }

 private:
  std::vector<double*> blocks() {
    std::vector<double*> blocks{unknowns_.left.data(), unknowns_.right.data(),
                                unknowns_.left_to_right.data()};
    for (PoseUnknowns& pose : unknowns_.boards) {
      blocks.push_back(pose.data());
    }
    return blocks;
  }

  void hold(LensUnknowns& lens, const PairFitOptions& options) {
    std::vector<int> held;
    if (!options.tangential) {
      held = {6, 7};
    }
    if (!options.k3) {
      held.push_back(8);
    }
    if (!held.empty()) {
      problem_.SetManifold(lens.data(), new ceres::SubsetManifold(int{kLensUnknowns}, held));
    }
  }

  void add(const Board& board, const PairView& view, PoseUnknowns& pose) {
    for (std::size_t i = 0; i < view.left.size(); ++i) {
      if (!view.left[i].seen()) {
        continue;
      }
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<LeftCorner, 2, kLensUnknowns, kPoseUnknowns>(
              new LeftCorner{board.at(static_cast<int>(i)), view.left[i],
                             whitening_of(view.left[i], usual_)}),
          new ceres::HuberLoss(kHuberPx), unknowns_.left.data(), pose.data());
    }
    for (std::size_t i = 0; i < view.right.size(); ++i) {
      if (!view.right[i].seen()) {
        continue;
      }
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RightCorner, 2, kLensUnknowns, kPoseUnknowns,
                                          kPoseUnknowns>(new RightCorner{
              board.at(static_cast<int>(i)), view.right[i], whitening_of(view.right[i], usual_)}),
          new ceres::HuberLoss(kHuberPx), unknowns_.right.data(), unknowns_.left_to_right.data(),
          pose.data());
    }
  }

  Unknowns unknowns_;
  double usual_;
  ceres::Problem problem_;
  std::shared_ptr<ceres::ParameterBlockOrdering> order_ =
      std::make_shared<ceres::ParameterBlockOrdering>();
};

// Which of the rig's unknowns the columns of the jacobian are, in their order.
std::vector<Eigen::Index> fitted_unknowns(const PairFitOptions& options) {
  std::vector<Eigen::Index> fitted;
  for (std::size_t i = 0; i < kRigUnknowns; ++i) {
    const std::size_t of_lens = i < 2 * kLensUnknowns ? i % kLensUnknowns : 0;
    const bool held =
        ((of_lens == 6 || of_lens == 7) && !options.tangential) || (of_lens == 8 && !options.k3);
    if (!held) {
      fitted.push_back(static_cast<Eigen::Index>(i));
    }
  }
  return fitted;
}

// What coefficients that are held at 0 may be, as far as the views tell, moves the others: added to
// the covariance of the fitted unknowns, whose places among all are `fitted`. Of such a coefficient
// the views say a value and how far that scatters; the larger of both is what it may be.
void add_what_is_held(const NormalEquations& all, const std::vector<Eigen::Index>& fitted,
                      double variance, Eigen::MatrixXd& covariance) {
  std::vector<Eigen::Index> held;
  for (Eigen::Index i = 0; i < all.matrix.rows(); ++i) {
    if (std::ranges::find(fitted, i) == fitted.end()) {
      held.push_back(i);
    }
  }
  if (held.empty()) {
    return;
  }
  const Eigen::MatrixXd moves = -covariance / variance * all.matrix(fitted, held);
  const Eigen::MatrixXd left = all.matrix(held, held) + all.matrix(held, fitted) * moves;
  const Eigen::VectorXd pull = all.right(held) + moves.transpose() * all.right(fitted);
  const Eigen::LDLT<Eigen::MatrixXd> solver(left);
  const Eigen::VectorXd found = -solver.solve(pull);
  const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd::Identity(left.rows(), left.cols()));
  if (solver.info() != Eigen::Success || !found.allFinite() || !inverse.allFinite()) {
    return;  // the views tell nothing of them
  }
  for (Eigen::Index k = 0; k < found.size(); ++k) {
    const double square = std::max(found(k) * found(k), variance * inverse(k, k));
    covariance += square * moves.col(k) * moves.col(k).transpose();
  }
}

dsp::RawPair rig_of(const Unknowns& unknowns, const dsp::RawPair& start) {
  dsp::RawPair rig = start;
  put_unknowns(unknowns.left, rig.left);
  put_unknowns(unknowns.right, rig.right);
  rig.left_to_right = transform_of(unknowns.left_to_right);
  return rig;
}

double coordinates_of(const PairView& view) {
  return static_cast<double>(2 * (seen_corners(view.left) + seen_corners(view.right)));
}

double sum_of_squares(const std::vector<PixelPoint>& residuals) {
  double sum = 0;
  for (const PixelPoint& r : residuals) {
    sum += r.seen() ? r.u * r.u + r.v * r.v : 0;
  }
  return sum;
}

// As if all corners were as certain as usual ones.
double whitened_squares(const std::vector<PixelPoint>& corners,
                        const std::vector<PixelPoint>& residuals, double usual) {
  double sum = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (residuals[i].seen()) {
      std::array<double, 2> off{residuals[i].u, residuals[i].v};
      whitening_of(corners[i], usual).apply(off.data());
      sum += off[0] * off[0] + off[1] * off[1];
    }
  }
  return sum;
}

ViewResiduals residuals_of(const Board& board, const PairView& view, const dsp::RawPair& rig,
                           const PoseUnknowns& pose) {
  const LensUnknowns left = unknowns_of(rig.left);
  const LensUnknowns right = unknowns_of(rig.right);
  const PoseUnknowns left_to_right = pose_of(rig.left_to_right);
  ViewResiduals residuals;
  std::array<double, 2> residual{};
  for (std::size_t i = 0; i < view.left.size(); ++i) {
    LeftCorner{board.at(static_cast<int>(i)), view.left[i]}(left.data(), pose.data(),
                                                            residual.data());
    residuals.left.push_back({.u = residual[0], .v = residual[1]});
  }
  for (std::size_t i = 0; i < view.right.size(); ++i) {
    RightCorner{board.at(static_cast<int>(i)), view.right[i]}(right.data(), left_to_right.data(),
                                                              pose.data(), residual.data());
    residuals.right.push_back({.u = residual[0], .v = residual[1]});
  }
  const double count = coordinates_of(view);
  residuals.rms_px =
      std::sqrt((sum_of_squares(residuals.left) + sum_of_squares(residuals.right)) / count);
  return residuals;
}

}  // namespace

std::optional<PairFit> fit_pair(const Board& board, const std::vector<PairView>& views,
                                const dsp::RawPair& start, const std::vector<PoseUnknowns>& boards,
                                const PairFitOptions& options) {
  Unknowns unknowns{unknowns_of(start.left), unknowns_of(start.right), pose_of(start.left_to_right),
                    boards};
  for (LensUnknowns* const lens : {&unknowns.left, &unknowns.right}) {
    if (!options.tangential) {
      (*lens)[6] = (*lens)[7] = 0;
    }
    if (!options.k3) {
      (*lens)[8] = 0;
    }
  }
  PairProblem problem(board, views, std::move(unknowns), options);
  if (!problem.solve(options.stop)) {
    return std::nullopt;
  }
  PairFit fit;
  fit.rig = rig_of(problem.unknowns(), start);
  fit.boards = problem.unknowns().boards;
  double coordinates = 0;
  const double usual = usual_variance(views);
  for (std::size_t n = 0; n < views.size(); ++n) {
    fit.residuals.push_back(residuals_of(board, views[n], fit.rig, fit.boards[n]));
    fit.cost += whitened_squares(views[n].left, fit.residuals[n].left, usual) +
                whitened_squares(views[n].right, fit.residuals[n].right, usual);
    coordinates += coordinates_of(views[n]);
  }
  std::optional<Eigen::MatrixXd> covariance = problem.covariance();
  const auto unknown_count =
      static_cast<double>(fitted_unknowns(options).size() + kPoseUnknowns * views.size());
  if (!covariance || !(coordinates > unknown_count)) {
    return std::nullopt;
  }
  const double variance = fit.cost / (coordinates - unknown_count);
  fit.corner_sigma_px = std::sqrt(variance);
  fit.covariance.setZero();
  const std::vector<Eigen::Index> fitted = fitted_unknowns(options);
  *covariance *= variance;
  if (const std::optional<NormalEquations> all = problem.equations_of_all()) {
    std::vector<Eigen::Index> columns = fitted;
    for (Eigen::Index i = int{kRigUnknowns}; i < all->matrix.rows(); ++i) {
      columns.push_back(i);
    }
    add_what_is_held(*all, columns, variance, *covariance);
  }
  for (std::size_t i = 0; i < fitted.size(); ++i) {
    for (std::size_t j = 0; j < fitted.size(); ++j) {
      fit.covariance(fitted[i], fitted[j]) =
          (*covariance)(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  return fit;
}

std::optional<ViewResiduals> judge_view(const Board& board, const PairView& view,
                                        const dsp::RawPair& rig) {
  const bool by_left = !view.left.empty();
  std::optional<PoseUnknowns> pose = by_left ? pose_of_board(board, view.left, rig.left)
                                             : pose_of_board(board, view.right, rig.right);
  if (!pose) {
    return std::nullopt;
  }
  if (!by_left) {
    const Matrix3 back = rotation_of(pose_of(rig.left_to_right)).transpose();
    const Vector3 moved_back =
        back * (translation_of(*pose) - translation_of(pose_of(rig.left_to_right)));
    pose = pose_of(back * rotation_of(*pose), moved_back);
  }
  LensUnknowns left = unknowns_of(rig.left);
  LensUnknowns right = unknowns_of(rig.right);
  PoseUnknowns left_to_right = pose_of(rig.left_to_right);
  ceres::Problem problem;
  for (std::size_t i = 0; i < view.left.size(); ++i) {
    if (!view.left[i].seen()) {
      continue;
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<LeftCorner, 2, kLensUnknowns, kPoseUnknowns>(
            new LeftCorner{board.at(static_cast<int>(i)), view.left[i]}),
        nullptr, left.data(), pose->data());
  }
  for (std::size_t i = 0; i < view.right.size(); ++i) {
    if (!view.right[i].seen()) {
      continue;
    }
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RightCorner, 2, kLensUnknowns,
                                                             kPoseUnknowns, kPoseUnknowns>(
                                 new RightCorner{board.at(static_cast<int>(i)), view.right[i]}),
                             nullptr, right.data(), left_to_right.data(), pose->data());
  }
  for (double* const block : {left.data(), right.data(), left_to_right.data()}) {
    if (problem.HasParameterBlock(block)) {
      problem.SetParameterBlockConstant(block);
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return std::nullopt;
  }
  return residuals_of(board, view, rig, *pose);
}

}  // namespace stof::host
