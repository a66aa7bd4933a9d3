#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "dsp/calib/calibration.h"
#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/corner_finder.h"
#include "host/calibrate/rig/target/lens_model.h"

// Both lenses of a pair and where they stand to each other, from views of a board: all of it in one
// least-squares fit (Ceres), with its covariance. Corners count by theirs (PixelPoint): residuals
// are whitened, so that the sum is of squared Mahalanobis distances (Hartley and Zisserman,
// Multiple View Geometry, chapter 4).
namespace stof::host {

// One pose of the board. An eye has all of its corners, those that it did not see as kUnseen; or
// none, where it did not find the board.
struct PairView {
  std::string name;
  std::vector<PixelPoint> left;
  std::vector<PixelPoint> right;

  bool both() const { return !left.empty() && !right.empty(); }
};

// The unknowns of a rig in the order of PairFit::covariance: left lens, right lens, then the pose
// of the left camera's axes in the right one's (rotation vector, translation).
inline constexpr std::size_t kRigUnknowns = 2 * kLensUnknowns + kPoseUnknowns;

struct PairFitOptions {
  bool k3 = true;                // fitted; else it stays 0
  bool tangential = true;        // p1 and p2 are
  std::function<bool()> stop{};  // asked after each step; true: ends without a fit
};

struct ViewResiduals {
  std::vector<PixelPoint> left;  // found less projected, px; kUnseen where the corner is
  std::vector<PixelPoint> right;
  double rms_px = 0;  // of both components together
};

struct PairFit {
  dsp::RawPair rig;
  // Of the unknowns, from the spread of the residuals, and from what k3, p1 and p2 may be as far as
  // the views tell, where they were not fitted; zero rows for those.
  Eigen::Matrix<double, int{kRigUnknowns}, int{kRigUnknowns}> covariance;
  double corner_sigma_px = 0;        // of one coordinate of a usual corner, from the residuals
  double cost = 0;                   // sum of squared residuals, px^2, each corner's shrunk or
                                     // stretched to those of a usual one
  std::vector<PoseUnknowns> boards;  // of each view: board to left camera
  std::vector<ViewResiduals> residuals;

  double sigma(std::size_t unknown) const {
    const auto i = static_cast<Eigen::Index>(unknown);
    return std::sqrt(covariance(i, i));
  }
};

// `start` has the pictures' sizes; its other numbers are where the search begins, and so are the
// poses `boards`, one a view. None where the fit does not converge or its covariance has no end:
// the views cannot tell all unknowns apart.
std::optional<PairFit> fit_pair(const Board& board, const std::vector<PairView>& views,
                                const dsp::RawPair& start, const std::vector<PoseUnknowns>& boards,
                                const PairFitOptions& options);

// Of a board in a view that a rig was not fitted to: the pose that suits both eyes best, and what
// it leaves. None where it does not converge.
std::optional<ViewResiduals> judge_view(const Board& board, const PairView& view,
                                        const dsp::RawPair& rig);

}  // namespace stof::host
