#include "host/calibrate/rig/target/target_calibration.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "dsp/calib/stereo/rectification.h"
#include "host/calibrate/rig/target/board_pose.h"
#include "host/evaluate/owning_converter.h"
#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/rendered_plane.h"

namespace stof::host {
namespace {

using test::angle_between;
using test::board_at;
using test::Gaussian;
using test::row_rms_of_truth;
using test::true_pair;
using test::view_of;
using test::waved;

constexpr Board kBoard{.columns = 9, .rows = 6, .square_m = 0.03};        // A4
constexpr Board kLargeBoard{.columns = 12, .rows = 9, .square_m = 0.04};  // A2
constexpr double kDegree = std::numbers::pi / 180;

TargetViews as_found(std::vector<PairView> views) {
  return {.width = 640, .height = 480, .views = std::move(views), .refused = {}};
}

TargetCalibration calibrated(std::vector<PairView> views, int hold_out = 5,
                             const Board& board = kBoard) {
  dataset::Loaded<TargetCalibration> found =
      calibrate_target(as_found(std::move(views)), {.board = board, .hold_out = hold_out});
  EXPECT_TRUE(found) << (found ? "" : found.error().message);
  return found ? std::move(*found) : TargetCalibration{};
}

TEST(TargetCalibration, TwentyViewsWithATenthOfAPixelOfNoiseGiveTheRig) {
  dsp::RawPair truth = true_pair();
  truth.left.p1 = truth.left.p2 = truth.right.p1 = truth.right.p2 = 0;
  constexpr int kSeeds = 5;
  double turned = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    // 20 to fit to, and at most 5 that judge.
    const TargetCalibration found =
        calibrated(waved(truth, kLargeBoard, 25, 0.1, seed), 5, kLargeBoard);
    const dsp::RawPair& rig = found.fit.rig;
    EXPECT_NEAR(rig.left.fx / truth.left.fx, 1, 0.003) << seed;
    EXPECT_NEAR(rig.right.fy / truth.right.fy, 1, 0.003) << seed;
    const double turn = angle_between(rig.left_to_right, truth.left_to_right) / kDegree;
    turned += turn * turn / kSeeds;
    std::printf("figure: seed %d: rotation %.4f degrees, row rms %.3f px, fx %.3f percent\n",
                static_cast<int>(seed), turn, row_rms_of_truth(truth, rig),
                (rig.left.fx / truth.left.fx - 1) * 100);
    EXPECT_LT(row_rms_of_truth(truth, rig), 0.1) << seed;
    EXPECT_NEAR(found.fit.corner_sigma_px, 0.1, 0.01) << seed;
    ASSERT_TRUE(found.judgement) << seed;
    EXPECT_NEAR(found.judgement->reprojection_px, 0.1, 0.02) << seed;
    EXPECT_FALSE(found.k3) << seed;
    EXPECT_FALSE(found.tangential) << seed;
  }
  EXPECT_LT(std::sqrt(turned), 0.03);
}

// Kernels once left registers behind in which LAPACK computes.
TEST(TargetCalibration, ALensFollowsFromViewsBehindFramesOfAPmdCamera) {
  dsp::PmdSensor sensor;
  sensor.lens = {.width = 64, .height = 16, .fx = 45, .fy = 45, .cx = 32, .cy = 8};
  OwningConverter converter(sensor);
  const std::vector<std::uint16_t> bright(64 * 16, 1500);
  const std::vector<std::uint16_t> dark(64 * 16, 500);
  const dsp::ImageView<const std::uint16_t> high(bright.data(), 64, 16);
  const dsp::ImageView<const std::uint16_t> low(dark.data(), 64, 16);
  converter->convert(dsp::PmdSamples{high, high, low, low});

  const dsp::RawPair truth = true_pair();
  std::vector<std::vector<PixelPoint>> views;  // that are enough for LAPACK to compute their lens
  for (const PairView& view : waved(truth, kBoard, 12, 0.1, 7)) {
    if (!view.left.empty()) {
      views.push_back(view.left);
    }
  }
  const std::optional<dsp::Pinhole> lens = lens_of_views(kBoard, views, 640, 480);
  ASSERT_TRUE(lens);
  EXPECT_NEAR(lens->fx / truth.left.fx, 1, 0.01);
}

TEST(TargetCalibration, ItEndsAtTheStepAtWhichItIsAskedTo) {
  const std::vector<PairView> views = waved(true_pair(), kBoard, 20, 0.1, 6);
  int steps = 0;
  ASSERT_TRUE(calibrate_target(as_found(views), {.board = kBoard}, [&] {
    ++steps;
    return false;
  }));
  // Three fits of some steps each. Rounding, which is not the same in each run, decides about the
  // last steps of each: the same fit may need some fewer.
  constexpr int kRounding = 4;
  EXPECT_GT(steps, 6 + kRounding);
  for (const int last : {1, 2, steps - kRounding}) {
    int asked = 0;
    const dataset::Loaded<TargetCalibration> found =
        calibrate_target(as_found(views), {.board = kBoard}, [&] { return ++asked == last; });
    ASSERT_FALSE(found) << last;
    EXPECT_EQ(found.error().message, "stopped");
    EXPECT_EQ(asked, last);
  }
}

TEST(TargetCalibration, ViewsThatJudgeAreNotThoseThatReachACorner) {
  // Each fifth view is held into a corner: none of these may be missing in the fit.
  const dsp::RawPair truth = true_pair();
  std::vector<PairView> views = waved(truth, kBoard, 25, 0.1, 4);
  const unsigned all = reached_corners(views, 640, 480);
  const TargetCalibration found = calibrated(std::move(views));
  EXPECT_GE(found.held_out.size(), 3U);
  EXPECT_EQ(reached_corners(found.fitted, 640, 480), all);
}

// p1 and p2 look much like a lens that is turned: what they leave is rows that correspond.
TEST(TargetCalibration, TangentialDistortionLeavesRowsThatCorrespond) {
  const dsp::RawPair truth = true_pair();
  const TargetCalibration found = calibrated(waved(truth, kLargeBoard, 25, 0.1, 1), 5, kLargeBoard);
  EXPECT_TRUE(found.tangential);
  EXPECT_NEAR(found.fit.rig.left.fx / truth.left.fx, 1, 0.003);
  EXPECT_LT(row_rms_of_truth(truth, found.fit.rig), 0.1);
}

// Boards with markers reach into all corners of both pictures: half of each is outside at times.
TEST(TargetCalibration, BoardsThatAreSeenInPartGiveTheRig) {
  const dsp::RawPair truth = true_pair();
  constexpr Board kMarked{.columns = 12,
                          .rows = 9,
                          .square_m = 0.04,
                          .kind = Board::Kind::kCharuco,
                          .share = 0.75,
                          .bits = 4};
  const PoseUnknowns to_right = pose_of(truth.left_to_right);
  Gaussian random(9);
  std::vector<PairView> views;
  std::size_t in_part = 0;
  while (views.size() < 25) {
    const double z = random.between(0.5, 1.4);
    const Vector3 middle(random.between(-0.5, 0.55) * z, random.between(-0.4, 0.4) * z, z);
    const PoseUnknowns pose = board_at(
        kMarked, middle,
        Vector3(random.between(-0.6, 0.6), random.between(-0.6, 0.6), random.between(-0.3, 0.3)));
    const Matrix3 turn = rotation_of(to_right);
    const PoseUnknowns in_right =
        pose_of(Matrix3(turn * rotation_of(pose)),
                Vector3(turn * translation_of(pose) + translation_of(to_right)));
    PairView view{.name = std::to_string(views.size()),
                  .left = test::seen_in_part(truth.left, pose, kMarked, 0.1, random),
                  .right = test::seen_in_part(truth.right, in_right, kMarked, 0.1, random)};
    if (view.both()) {
      in_part += seen_corners(view.left) < view.left.size() ? 1U : 0U;
      views.push_back(std::move(view));
    }
  }
  EXPECT_GT(in_part, 5U);
  const TargetCalibration found = calibrated(std::move(views), 5, kMarked);
  ASSERT_TRUE(found.judgement);
  const double turned = angle_between(found.fit.rig.left_to_right, truth.left_to_right) / kDegree;
  std::printf(
      "figure: boards seen in part: rotation %.4f degrees, row rms %.3f px, fx %.3f percent\n",
      turned, row_rms_of_truth(truth, found.fit.rig),
      (found.fit.rig.left.fx / truth.left.fx - 1) * 100);
  EXPECT_NEAR(found.fit.rig.left.fx / truth.left.fx, 1, 0.003);
  EXPECT_LT(row_rms_of_truth(truth, found.fit.rig), 0.1);
  EXPECT_NEAR(found.fit.corner_sigma_px, 0.1, 0.01);
  EXPECT_NEAR(found.judgement->reprojection_px, 0.1, 0.02);
  EXPECT_LT(std::abs(found.judgement->scale_error), 0.005);
  EXPECT_TRUE(found.missing.empty());
}

TEST(TargetCalibration, TheCovarianceIsThatOfTheErrors) {
  const dsp::RawPair truth = true_pair();
  const LensUnknowns left = unknowns_of(truth.left);
  constexpr int kSeeds = 25;
  double sum = 0;
  for (std::uint64_t seed = 100; seed < 100 + kSeeds; ++seed) {
    const std::vector<PairView> views = waved(truth, kBoard, 12, 0.1, seed);
    const TargetCalibration found = calibrated(views, 0);
    const PoseUnknowns a = pose_of(found.fit.rig.left_to_right);
    const PoseUnknowns b = pose_of(truth.left_to_right);
    Eigen::Matrix<double, 6, 1> error;
    for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
      error(static_cast<Eigen::Index>(i)) = a[i] - b[i];
    }
    const Eigen::Matrix<double, 6, 6> covariance = found.fit.covariance.bottomRightCorner<6, 6>();
    sum += error.dot(covariance.inverse() * error);
    ASSERT_GT(found.fit.sigma(0), 0);
    EXPECT_LT(std::abs(found.fit.rig.left.fx - left[0]), 5 * found.fit.sigma(0)) << seed;
  }
  // 6 degrees of freedom, 25 seeds: sigma of the mean is sqrt(12 / 25) = 0.69.
  EXPECT_NEAR(sum / kSeeds, 6, 2.1);
}

// A k3 too small to be asked for bends k1 and k2 all the same.
TEST(TargetCalibration, ACoefficientThatIsLeftOutMakesTheOthersUncertain) {
  constexpr int kSeeds = 30;
  std::array<double, 4> squared{};  // k1, k2 of the left lens, of the right one
  double focal = 0;
  int without = 0;
  for (std::uint64_t seed = 300; seed < 300 + kSeeds; ++seed) {
    Gaussian random(seed);
    dsp::RawPair truth = true_pair();
    truth.left.p1 = truth.left.p2 = truth.right.p1 = truth.right.p2 = 0;
    truth.left.k3 = random.next(0.02);
    truth.right.k3 = random.next(0.02);
    const TargetCalibration found = calibrated(waved(truth, kBoard, 20, 0.05, seed), 0);
    if (found.k3) {
      continue;
    }
    ++without;
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const LensUnknowns lens = unknowns_of(eye == 0 ? found.fit.rig.left : found.fit.rig.right);
      const LensUnknowns known = unknowns_of(eye == 0 ? truth.left : truth.right);
      const std::size_t first = eye * kLensUnknowns;
      for (std::size_t k = 0; k < 2; ++k) {
        squared[2 * eye + k] +=
            std::pow((lens[4 + k] - known[4 + k]) / found.fit.sigma(first + 4 + k), 2);
      }
      focal += std::pow((lens[0] - known[0]) / found.fit.sigma(first), 2) / 2;
    }
  }
  ASSERT_GT(without, 12);
  std::printf("figure: k3 left out in %d of %d: mean normalised squared errors of k1, k2:", without,
              kSeeds);
  for (const double sum : squared) {
    std::printf(" %.2f", sum / without);
  }
  std::printf("; of fx %.2f\n", focal / without);
  for (const double sum : squared) {
    EXPECT_GT(sum / without, 0.35);
    EXPECT_LT(sum / without, 2);
  }
}

// Every other corner scatters ten times as far, and says so or does not.
TEST(TargetCalibration, CornersCountByHowCertainTheyAre) {
  dsp::RawPair truth = true_pair();
  truth.left.p1 = truth.left.p2 = truth.right.p1 = truth.right.p2 = 0;
  constexpr int kSeeds = 12;
  double told = 0;
  double untold = 0;
  double squared = 0;
  const auto error_of = [&](const PairFit& fit) {
    const PoseUnknowns a = pose_of(fit.rig.left_to_right);
    const PoseUnknowns b = pose_of(truth.left_to_right);
    Eigen::Matrix<double, 6, 1> error;
    for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
      error(static_cast<Eigen::Index>(i)) = a[i] - b[i];
    }
    return error;
  };
  for (std::uint64_t seed = 200; seed < 200 + kSeeds; ++seed) {
    std::vector<PairView> views = waved(truth, kBoard, 12, 0.05, seed);
    Gaussian random(seed);
    for (PairView& view : views) {
      for (std::vector<PixelPoint>* const eye : {&view.left, &view.right}) {
        for (std::size_t i = 0; i < eye->size(); i += 2) {
          (*eye)[i].u += random.next(0.5);
          (*eye)[i].v += random.next(0.5);
        }
      }
    }
    untold += error_of(calibrated(views, 0).fit).head<3>().squaredNorm();
    for (PairView& view : views) {
      for (std::vector<PixelPoint>* const eye : {&view.left, &view.right}) {
        for (std::size_t i = 0; i < eye->size(); ++i) {
          (*eye)[i].uu = (*eye)[i].vv = i % 2 == 0 ? 0.2525 : 0.0025;
        }
      }
    }
    const PairFit fit = calibrated(views, 0).fit;
    const Eigen::Matrix<double, 6, 1> error = error_of(fit);
    told += error.head<3>().squaredNorm();
    const Eigen::Matrix<double, 6, 6> covariance = fit.covariance.bottomRightCorner<6, 6>();
    squared += error.dot(covariance.inverse() * error) / kSeeds;
  }
  std::printf("figure: rotation off by %.4f degrees where corners tell, %.4f where not\n",
              std::sqrt(told / kSeeds) / kDegree, std::sqrt(untold / kSeeds) / kDegree);
  EXPECT_LT(told, 0.25 * untold);
  // 6 degrees of freedom, 12 seeds: sigma of the mean is 1.
  EXPECT_NEAR(squared, 6, 3.5);
}

TEST(TargetCalibration, FindsK3WhereTheLensHasIt) {
  dsp::RawPair truth = true_pair();
  truth.left.k3 = truth.right.k3 = -0.12;
  const TargetCalibration found = calibrated(waved(truth, kBoard, 20, 0.05, 3));
  EXPECT_TRUE(found.k3);
  EXPECT_LT(row_rms_of_truth(truth, found.fit.rig), 0.1);
}

TEST(TargetCalibration, SaysWhichViewIsMissing) {
  const dsp::RawPair truth = true_pair();
  const auto views_at = [&](double nearest, double farthest, double tilt, double spread) {
    Gaussian random(7);
    std::vector<PairView> views;
    while (views.size() < 16) {
      const double z = random.between(nearest, farthest);
      const Vector3 middle(random.between(-spread, spread) * z, random.between(-spread, spread) * z,
                           z);
      const Vector3 turn(random.between(-tilt, tilt), random.between(-tilt, tilt), 0);
      PairView view = view_of(truth, kBoard, board_at(kBoard, middle, turn), 0.05, random);
      if (view.both()) {
        view.name = std::to_string(views.size());
        views.push_back(std::move(view));
      }
    }
    return views;
  };
  const auto missing = [](const std::vector<PairView>& views) {
    std::string all;
    const dataset::Loaded<TargetCalibration> found =
        calibrate_target(as_found(views), {.board = kBoard});
    if (!found) {
      return found.error().message;
    }
    for (const std::string& line : found->missing) {
      all += line + "\n";
    }
    return all;
  };
  EXPECT_EQ(missing(waved(truth, kBoard, 40, 0.1, 11)), "");
  EXPECT_NE(missing(views_at(1.1, 2.2, 0.6, 0.3)).find("near:"), std::string::npos);
  EXPECT_NE(missing(views_at(0.5, 0.6, 0.6, 0.3)).find("far:"), std::string::npos);
  EXPECT_NE(missing(views_at(0.5, 1.2, 0.02, 0.4)).find("tilted"), std::string::npos);
  EXPECT_NE(missing(views_at(0.5, 1.2, 0.6, 0.02)).find("corners: no view reaches the upper left"),
            std::string::npos);
}

TEST(TargetCalibration, LeavesOutAViewThatDoesNotFit) {
  std::vector<PairView> views = waved(true_pair(), kBoard, 20, 0.1, 5);
  for (PixelPoint& corner : views[7].left) {
    corner.u += 2e-4 * (corner.v - 200) * (corner.u - 300);  // the board was bent
  }
  const TargetCalibration found = calibrated(views, 0);
  ASSERT_EQ(found.refused.size(), 1U);
  EXPECT_EQ(found.refused[0].name, "7");
}

TEST(TargetCalibration, RefusesWhatNoPairShows) {
  std::vector<PairView> exchanged = waved(true_pair(), kBoard, 20, 0.1, 5);
  for (PairView& view : exchanged) {
    std::swap(view.left, view.right);
  }
  const auto refusal = [](std::vector<PairView> views) {
    const dataset::Loaded<TargetCalibration> found =
        calibrate_target(as_found(std::move(views)), {.board = kBoard});
    EXPECT_FALSE(found);
    return found ? std::string() : found.error().message;
  };
  const std::string swapped = refusal(std::move(exchanged));
  EXPECT_NE(swapped.find("left and right are not exchanged"), std::string::npos) << swapped;
  const std::string crumpled = refusal(waved(true_pair(), kBoard, 20, 2, 5));
  EXPECT_NE(crumpled.find("1.0 are allowed: check that the board is flat"), std::string::npos)
      << crumpled;
}

TEST(TargetCalibration, ViewsThatAreAllAlikeAreNotTakenForExchangedEyes) {
  const dsp::RawPair truth = true_pair();
  Gaussian random(4);
  const PoseUnknowns pose = board_at(kBoard, Vector3(0.03, 0.02, 0.6), Vector3(0.1, 0.02, 0.1));
  const PoseUnknowns in_right = test::seen_from(pose_of(truth.left_to_right), pose);
  std::vector<PairView> views;
  for (int n = 0; n < 12; ++n) {
    views.push_back({.name = std::to_string(n),
                     .left = test::seen_in_part(truth.left, pose, kBoard, 0.02, random),
                     .right = test::seen_in_part(truth.right, in_right, kBoard, 0.02, random)});
  }
  const dataset::Loaded<TargetCalibration> found =
      calibrate_target(as_found(views), {.board = kBoard});
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("too much alike: tilted"), std::string::npos)
      << found.error().message;
  EXPECT_EQ(found.error().message.find("exchanged"), std::string::npos) << found.error().message;
}

TEST(TargetCalibration, SaysThatMostViewsDoNotCount) {
  TargetViews views = as_found(waved(true_pair(), kBoard, 20, 0.1, 6));
  views.views.resize(1);
  views.refused = {{"a", "blurred: edges ..."}, {"b", "blurred: edges ..."}};
  const dataset::Loaded<TargetCalibration> found = calibrate_target(views, {.board = kBoard});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().message,
            "2 views of 3 do not count (a: blurred: edges ...): take them anew");
}

TEST(TargetCalibration, KnowsTheRigOfBefore) {
  dsp::Calibration before;
  before.stereo.raw = true_pair();
  ASSERT_STREQ(dsp::complete(before.stereo), "");
  dsp::RawPair pair = true_pair();
  EXPECT_EQ(other_rig(before, pair), "");
  EXPECT_EQ(other_rig({}, pair), "");
  pair.left_to_right.translation_m[0] *= 1.25;  // squares of 30 mm that were told to be 24 mm
  EXPECT_NE(other_rig(before, pair).find("measure a square of the board"), std::string::npos);
  pair = true_pair();
  pair.left.width = pair.right.width = 320;
  EXPECT_NE(other_rig(before, pair).find("the views have 320x480"), std::string::npos);
}

TEST(TargetCalibration, KeepsThePmdCameraWhereItWasAgainstTheLeftEye) {
  dsp::Calibration before;
  before.stereo.raw = true_pair();
  ASSERT_STREQ(dsp::complete(before.stereo), "");
  before.pmd.lens = {.width = 64, .height = 16, .fx = 45, .fy = 45, .cx = 32, .cy = 8};
  before.pmd_to_stereo = transform_of(PoseUnknowns{0.1, 0.02, -0.03, 0.05, -0.04, 0.01});
  dsp::RawPair turned = true_pair();
  turned.left_to_right = transform_of(PoseUnknowns{0.03, -0.05, 0.02, -0.12, 0.006, -0.004});
  const dsp::Calibration after = with_pair(before, turned);
  const auto in_left = [](const dsp::Calibration& calibration, const Vector3& p) {
    const PoseUnknowns pose = pose_of(calibration.pmd_to_stereo);
    const dsp::Rectification rectified = dsp::rectify(*calibration.stereo.raw);
    const Matrix3 turn =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rectified.left_turn.data());
    return Vector3(turn.transpose() * (rotation_of(pose) * p + translation_of(pose)));
  };
  const Vector3 point(0.3, -0.2, 1.7);
  EXPECT_LT((in_left(before, point) - in_left(after, point)).norm(), 1e-12);
}

}  // namespace
}  // namespace stof::host
