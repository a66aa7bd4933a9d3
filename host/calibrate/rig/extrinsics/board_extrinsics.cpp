#include "host/calibrate/rig/extrinsics/board_extrinsics.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <opencv2/imgproc.hpp>

#include "dsp/base/index.h"
#include "dsp/calib/stereo/rectification.h"
#include "host/calibrate/rig/extrinsics/corner_noise.h"
#include "host/calibrate/rig/fit_covariance.h"
#include "host/calibrate/rig/target/board_pose.h"
#include "host/calibrate/rig/target/corner_refiner.h"
#include "host/calibrate/rig/target/corner_whitening.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

using dsp::index;
using RowMatrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr int kRounds = 4;  // of fits, each with the noise that the one before it found
constexpr double kHuberSigmas = 3;
constexpr int kEnlarged = 4;
constexpr double kWhite = 250;
// What corners of all views share, as a part of the distance: the camera seems to stand nearer or
// farther by it. No view disagrees of it. Measured on 91 rendered rigs (scripts/calib_bench's
// numbers 601 to 700), where it is 0.0004 px at the edge of the picture.
constexpr double kSharedScale = 4e-6;

template <typename T>
std::array<T, 3> moved(const T* pose, const std::array<T, 3>& point) {
  std::array<T, 3> turned;
  ceres::AngleAxisRotatePoint(pose, point.data(), turned.data());
  return {turned[0] + pose[3], turned[1] + pose[4], turned[2] + pose[5]};
}

template <typename T>
std::array<T, 3> times(const Matrix3& m, const std::array<T, 3>& p) {
  std::array<T, 3> out;
  for (int i = 0; i < 3; ++i) {
    out[index(i)] = T(m(i, 0)) * p[0] + T(m(i, 1)) * p[1] + T(m(i, 2)) * p[2];
  }
  return out;
}

template <typename T>
bool off(const LensUnknowns& lens, const std::array<T, 3>& point, const PixelPoint& found,
         const Whitening& whitening, T* residual) {
  std::array<T, kLensUnknowns> numbers;
  std::ranges::transform(lens, numbers.begin(), [](double x) { return T(x); });
  std::array<T, 2> pixel;
  if (!project(numbers.data(), point, pixel)) {
    return false;
  }
  residual[0] = found.u - pixel[0];
  residual[1] = found.v - pixel[1];
  whitening.apply(residual);
  return true;
}

// By an eye whose place to the left camera is fixed.
struct EyeCorner {
  LensUnknowns lens;
  PoseUnknowns from_left;
  std::array<double, 2> on_board;
  PixelPoint found;
  Whitening whitening;

  template <typename T>
  bool operator()(const T* board, T* residual) const {
    std::array<T, kPoseUnknowns> eye;
    std::ranges::transform(from_left, eye.begin(), [](double x) { return T(x); });
    return off(lens, moved(eye.data(), moved(board, {T(on_board[0]), T(on_board[1]), T(0)})), found,
               whitening, residual);
  }
};

struct PmdCorner {
  LensUnknowns lens;
  Matrix3 left_turn;
  Matrix3 start_back;  // R^T of the start
  std::array<double, 2> on_board;
  PixelPoint found;
  Whitening whitening;

  // pose: a small turn behind the start's, and T.
  template <typename T>
  bool operator()(const T* pose, const T* board, T* residual) const {
    std::array<T, 3> point = times(left_turn, moved(board, {T(on_board[0]), T(on_board[1]), T(0)}));
    for (std::size_t i = 0; i < 3; ++i) {
      point[i] -= pose[3 + i];
    }
    const T back[3] = {-pose[0], -pose[1], -pose[2]};
    std::array<T, 3> turned;
    ceres::AngleAxisRotatePoint(back, point.data(), turned.data());
    return off(lens, times(start_back, turned), found, whitening, residual);
  }
};

// A corner in the problem.
struct Block {
  ceres::ResidualBlockId id;
  PixelPoint found;
  Whitening whitening;
};

// Each block's, in standard deviations.
std::vector<double> residuals_of(ceres::Problem& problem, const std::vector<Block>& blocks) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  for (const Block& block : blocks) {
    options.residual_blocks.push_back(block.id);
  }
  std::vector<double> residuals;
  problem.Evaluate(options, nullptr, &residuals, nullptr, nullptr);
  return residuals;
}

struct RigNoise {
  CornerNoise pair;
  CornerNoise pmd;
};

using Square = Eigen::Matrix<double, 6, 6>;

// What a view alone says of the camera's place.
struct ViewEquations {
  Square matrix;
  Eigen::Matrix<double, 6, 1> right;
};

// The board's pose, the last six unknowns, is the view's own.
ViewEquations without_board(const NormalEquations& view) {
  const Square both = view.matrix.topRightCorner<6, 6>();
  const Eigen::LDLT<Square> board(Square(view.matrix.bottomRightCorner<6, 6>()));
  return {view.matrix.topLeftCorner<6, 6>() - both * board.solve(both.transpose()),
          view.right.head<6>() - both * board.solve(view.right.tail<6>())};
}

struct Disagreement {
  double scale = 1;
  double freedom = 0;  // of the scale
};

class BoardProblem {
 public:
  BoardProblem(const Board& board, const std::vector<PmdBoardView>& views, const FixedPair& pair,
               const dsp::Pinhole& pmd, const PoseUnknowns& start,
               const std::vector<PoseUnknowns>& boards, const RigNoise& noise)
      : start_(rotation_of(start)),
        pose_{0, 0, 0, start[3], start[4], start[5]},
        boards_(boards),
        of_view_(views.size()),
        blocks_(views.size()) {
    const PoseUnknowns home{};
    const Matrix3 left_turn = Eigen::Map<const RowMatrix>(pair.left_turn.data());
    for (std::size_t n = 0; n < views.size(); ++n) {
      add_eye(board, views[n].pair.left, pair.rig.left, home, noise.pair, n);
      add_eye(board, views[n].pair.right, pair.rig.right, pose_of(pair.rig.left_to_right),
              noise.pair, n);
      for (std::size_t i = 0; i < views[n].pmd.size(); ++i) {
        const PixelPoint& found = views[n].pmd[i];
        const Whitening whitening = whitening_of(found, noise.pmd.scale, noise.pmd.floor);
        auto* const id = problem_.AddResidualBlock(
            new ceres::AutoDiffCostFunction<PmdCorner, 2, kPoseUnknowns, kPoseUnknowns>(
                new PmdCorner{unknowns_of(pmd), left_turn, start_.transpose(),
                              board.at(static_cast<int>(i)), found, whitening}),
            new ceres::HuberLoss(kHuberSigmas), pose_.data(), boards_[n].data());
        of_view_[n].push_back({id, found, whitening});
        pmd_.push_back(of_view_[n].back());
        blocks_[n].push_back(id);
      }
    }
  }

  bool solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 100;
    options.function_tolerance = 1e-12;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  PoseUnknowns pose() const {
    const PoseUnknowns small{pose_[0], pose_[1], pose_[2], 0, 0, 0};
    return pose_of(Matrix3(rotation_of(small) * start_), Vector3(pose_[3], pose_[4], pose_[5]));
  }
  const std::vector<PoseUnknowns>& boards() const { return boards_; }
  // What corners scatter by: unknowns take some of it away.
  RigNoise noise(const RigNoise& told) {
    const auto corners = static_cast<double>(2 * (pair_.size() + pmd_.size()));
    const auto unknowns = static_cast<double>(kPoseUnknowns * (1 + boards_.size()));
    const double freedom = (corners - unknowns) / corners;
    return {.pair = corner_noise(off_of(pair_), freedom, told.pair),
            .pmd = corner_noise(off_of(pmd_), freedom, told.pmd)};
  }
  double view_misfit(std::size_t n) {
    double sum = 0;
    for (const double residual : residuals_of(problem_, of_view_[n])) {
      sum += residual * residual;
    }
    return std::sqrt(sum / static_cast<double>(2 * of_view_[n].size()));
  }

  // How far views place the PMD camera apart, each by itself, over what their corners' scatter
  // tells: squared, near 1 where corners of a view are off independently. Views count as they do
  // in the fit (a near one says more, and is off by more of its own): the trace of the covariance
  // that is robust to what a view's corners share (Liang and Zeger 1986) over that of the fit's
  // own. None where a view places nothing.
  std::optional<Disagreement> disagreement() {
    std::vector<ViewEquations> views;
    Square all = Square::Zero();
    for (std::size_t n = 0; n < boards_.size(); ++n) {
      const std::optional<NormalEquations> view =
          normal_equations(problem_, blocks_[n], {pose_.data(), boards_[n].data()});
      if (!view) {
        return std::nullopt;
      }
      views.push_back(without_board(*view));
      all += views.back().matrix;
    }
    const Square inverse = all.ldlt().solve(Square::Identity());
    double found = 0;
    double expected = kPoseUnknowns;  // less what the fit has taken of it
    double weights = 0;               // squared
    for (const ViewEquations& view : views) {
      const Square share = inverse * view.matrix;
      found += view.right.dot(inverse * view.right);
      expected -= (share * share).trace();
      weights += share.trace() * share.trace();
    }
    const Disagreement out{
        .scale = found / expected,
        .freedom = kPoseUnknowns * (kPoseUnknowns * kPoseUnknowns / weights - 1)};
    const bool usable = out.scale > 0 && std::isfinite(out.scale) && out.freedom > 2;
    return usable ? std::optional(out) : std::nullopt;
  }

  std::optional<Eigen::Matrix<double, 6, 6>> covariance() {
    std::vector<double*> unknowns{pose_.data()};
    for (PoseUnknowns& board : boards_) {
      unknowns.push_back(board.data());
    }
    const std::optional<Eigen::MatrixXd> all = fit_covariance(problem_, unknowns);
    return all ? std::optional<Eigen::Matrix<double, 6, 6>>(all->topLeftCorner<6, 6>())
               : std::nullopt;
  }

 private:
  void add_eye(const Board& board, const std::vector<PixelPoint>& corners, const dsp::Pinhole& lens,
               const PoseUnknowns& from_left, const CornerNoise& noise, std::size_t n) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Whitening whitening = whitening_of(corners[i], noise.scale, noise.floor);
      auto* const id = problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<EyeCorner, 2, kPoseUnknowns>(new EyeCorner{
              unknowns_of(lens), from_left, board.at(static_cast<int>(i)), corners[i], whitening}),
          new ceres::HuberLoss(kHuberSigmas), boards_[n].data());
      pair_.push_back({id, corners[i], whitening});
      blocks_[n].push_back(id);
    }
  }

  std::vector<CornerOff> off_of(const std::vector<Block>& blocks) {
    const std::vector<double> residuals = residuals_of(problem_, blocks);
    std::vector<CornerOff> off;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Whitening& w = blocks[i].whitening;
      const double u = residuals[2 * i] / w.uu;
      off.push_back({blocks[i].found, u, (residuals[2 * i + 1] - w.vu * u) / w.vv});
    }
    return off;
  }

  Matrix3 start_;
  PoseUnknowns pose_;
  std::vector<PoseUnknowns> boards_;
  ceres::Problem problem_;
  std::vector<Block> pair_;
  std::vector<Block> pmd_;
  std::vector<std::vector<Block>> of_view_;                  // of the PMD camera
  std::vector<std::vector<ceres::ResidualBlockId>> blocks_;  // of each view, of all cameras
};

// Of the boards from the left camera, m; the PMD camera is beside it.
double mean_distance(const std::vector<PoseUnknowns>& boards) {
  double sum = 0;
  for (const PoseUnknowns& board : boards) {
    sum += translation_of(board).z();
  }
  return sum / static_cast<double>(boards.size());
}

// From the first view's poses to both cameras.
std::optional<PoseUnknowns> first_pose(const Board& board, const PmdBoardView& view,
                                       const FixedPair& pair, const dsp::Pinhole& pmd) {
  const std::optional<PoseUnknowns> by_left = pose_of_board(board, view.pair.left, pair.rig.left);
  const std::optional<PoseUnknowns> by_pmd = pose_of_board(board, view.pmd, pmd);
  if (!by_left || !by_pmd) {
    return std::nullopt;
  }
  const Matrix3 left_turn = Eigen::Map<const RowMatrix>(pair.left_turn.data());
  const Matrix3 turn = left_turn * rotation_of(*by_left) * rotation_of(*by_pmd).transpose();
  return pose_of(turn,
                 Vector3(left_turn * translation_of(*by_left) - turn * translation_of(*by_pmd)));
}

}  // namespace

FixedPair fixed_pair(const dsp::StereoRig& rig) {
  if (rig.raw) {
    return {*rig.raw, dsp::rectify(*rig.raw).left_turn};
  }
  FixedPair pair{.rig = {.left = rig.left, .right = rig.left, .left_to_right = {}}};
  pair.rig.right.cx += rig.doff_px;
  pair.rig.left_to_right.translation_m = {-rig.baseline_m, 0, 0};
  return pair;
}

std::optional<ExtrinsicFit> fit_extrinsics(const Board& board,
                                           const std::vector<PmdBoardView>& views,
                                           const FixedPair& pair, const dsp::Pinhole& pmd) {
  if (views.size() < kFewestBoardViews) {
    return std::nullopt;
  }
  std::optional<PoseUnknowns> pose = first_pose(board, views.front(), pair, pmd);
  std::vector<PoseUnknowns> boards;
  for (const PmdBoardView& view : views) {
    const std::optional<PoseUnknowns> by_left = pose_of_board(board, view.pair.left, pair.rig.left);
    if (!by_left || !pose) {
      return std::nullopt;
    }
    boards.push_back(*by_left);
  }
  RigNoise noise;
  for (int round = 0;; ++round) {
    BoardProblem problem(board, views, pair, pmd, *pose, boards, noise);
    if (!problem.solve()) {
      return std::nullopt;
    }
    pose = problem.pose();
    if (round + 1 < kRounds) {
      boards = problem.boards();
      noise = problem.noise(noise);
      continue;
    }
    ExtrinsicFit fit;
    fit.pmd_to_stereo = *pose;
    const std::optional<Eigen::Matrix<double, 6, 6>> covariance = problem.covariance();
    const std::optional<Disagreement> disagreement = problem.disagreement();
    if (!covariance || !disagreement) {
      return std::nullopt;
    }
    // Corners of a view share errors that their scatter does not show; views do not. A scale that
    // is found from few views makes errors those of Student's t, whose variance is larger.
    fit.misfit = disagreement->scale;
    fit.covariance = fit.misfit * disagreement->freedom / (disagreement->freedom - 2) * *covariance;
    const Vector3 shared =
        kSharedScale * mean_distance(problem.boards()) * rotation_of(fit.pmd_to_stereo).col(2);
    fit.covariance.bottomRightCorner<3, 3>() += shared * shared.transpose();
    for (std::size_t n = 0; n < views.size(); ++n) {
      fit.wall_misfit.push_back(problem.view_misfit(n));
    }
    return fit;
  }
}

std::string contradiction_of_views(const ExtrinsicFit& fit) {
  return fit.misfit <= kLargestViewMisfit
             ? std::string()
             : printed(
                   "views disagree of the PMD camera's place, squared, %.0f times as much as "
                   "corners scatter (%.0f is allowed)",
                   fit.misfit, kLargestViewMisfit);
}

std::vector<PixelPoint> corners_in_amplitude(const dataset::Image<float>& amplitude,
                                             const dsp::Pinhole& lens, const Board& board) {
  const float most = std::ranges::max(amplitude.pixels);
  if (!(most > 0)) {
    return {};
  }
  cv::Mat small(amplitude.height, amplitude.width, CV_8UC1);
  for (int y = 0; y < amplitude.height; ++y) {
    for (int x = 0; x < amplitude.width; ++x) {
      small.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(
          std::clamp(static_cast<double>(amplitude.view().at(x, y) / most) * kWhite, 0.0, 255.0));
    }
  }
  cv::Mat large;
  cv::resize(small, large, {}, kEnlarged, kEnlarged, cv::INTER_CUBIC);
  dataset::Image<std::uint8_t> picture(large.cols, large.rows);
  for (int y = 0; y < large.rows; ++y) {
    std::copy_n(large.ptr<std::uint8_t>(y), large.cols, picture.view().row(y).begin());
  }
  const std::optional<FoundBoard> found = find_board_roughly(picture, board);
  if (!found) {
    return {};
  }
  std::vector<PixelPoint> corners;
  for (const PixelPoint& p : found->corners) {
    // The centre of a pixel of before is in the middle of those that it became.
    corners.push_back({(p.u + 0.5) / kEnlarged - 0.5, (p.v + 0.5) / kEnlarged - 0.5});
  }
  // Enlarging invents nothing: where a corner is, the picture itself tells.
  refine_corners(amplitude, board, corners, {.lens = &lens});
  return corners;
}

}  // namespace stof::host
