#include "host/calibrate/rig/extrinsics/board_extrinsics.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "dsp/calib/stereo/rectification.h"
#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/rendered_plane.h"

namespace stof::host {
namespace {

using test::Gaussian;

constexpr double kDegree = std::numbers::pi / 180;
constexpr Board kBoard{.columns = 9, .rows = 6, .square_m = 0.06};
const dsp::Pinhole kPmd{
    .width = 176, .height = 144, .fx = 180, .fy = 180, .cx = 88, .cy = 72, .k1 = -0.1};
const PoseUnknowns kTruth{0.03, -0.05, 0.02, 0.09, -0.03, 0.02};  // rectified left from PMD

PoseUnknowns pmd_from_left(const FixedPair& pair) {
  const Matrix3 left_turn =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pair.left_turn.data());
  const Matrix3 back = rotation_of(kTruth).transpose();
  return pose_of(Matrix3(back * left_turn), Vector3(-back * translation_of(kTruth)));
}

std::vector<PmdBoardView> views(const FixedPair& pair, std::uint64_t seed, double noise = 1) {
  Gaussian random(seed);
  std::vector<PmdBoardView> found;
  const PoseUnknowns to_pmd = pmd_from_left(pair);
  while (found.size() < 10) {
    const double z = random.between(1.0, 1.6);
    const PoseUnknowns pose = test::board_at(
        kBoard, Vector3(random.between(-0.15, 0.2) * z, random.between(-0.15, 0.15) * z, z),
        Vector3(random.between(-0.6, 0.6), random.between(-0.6, 0.6), random.between(-0.2, 0.2)));
    PmdBoardView view{
        .pair = test::view_of(pair.rig, kBoard, pose, 0.1 * noise, random),
        .pmd = test::seen_by(kPmd, test::seen_from(to_pmd, pose), kBoard, 0.07 * noise, random)};
    if (view.pair.both() && !view.pmd.empty()) {
      found.push_back(std::move(view));
    }
  }
  return found;
}

FixedPair raw_pair() {
  dsp::StereoRig rig;
  rig.raw = test::true_pair();
  EXPECT_STREQ(dsp::complete(rig), "");
  return fixed_pair(rig);
}

TEST(BoardExtrinsics, PlaceThePmdCameraAndTheirCovarianceIsThatOfTheErrors) {
  constexpr int kSeeds = 100;
  constexpr double kEllipsoid95 = 12.592;  // chi^2, 6 degrees of freedom
  const FixedPair pair = raw_pair();
  double mean = 0, turn = 0, shift = 0;
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const std::optional<ExtrinsicFit> fit = fit_extrinsics(kBoard, views(pair, seed), pair, kPmd);
    ASSERT_TRUE(fit) << seed;
    EXPECT_EQ(contradiction_of_views(*fit), "") << seed;
    const Eigen::Matrix<double, 6, 1> off = difference(fit->pmd_to_stereo, kTruth);
    const double squared = off.dot(fit->covariance.inverse() * off);
    mean += squared / kSeeds;
    inside += squared <= kEllipsoid95 ? 1 : 0;
    turn = std::max(turn, off.head<3>().norm());
    shift = std::max(shift, off.tail<3>().norm());
  }
  std::printf(
      "figure: boards: mean NEES %.2f, %d of 100 inside, turn %.3f degrees, shift %.1f mm\n", mean,
      inside, turn / kDegree, shift * 1000);
  EXPECT_GT(mean, 5.3);
  EXPECT_LT(mean, 6.7);
  EXPECT_GE(inside, 90);
  EXPECT_LT(turn, 0.1 * kDegree);
  EXPECT_LT(shift, 0.005);
}

TEST(BoardExtrinsics, ViewsThroughAnotherLensContradictEachOther) {
  const FixedPair pair = raw_pair();
  dsp::Pinhole lens = kPmd;
  lens.fx *= 1.01;
  lens.fy *= 1.01;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const std::optional<ExtrinsicFit> fit =
        fit_extrinsics(kBoard, views(pair, seed, 0.1), pair, lens);
    ASSERT_TRUE(fit) << seed;
    EXPECT_NE(contradiction_of_views(*fit).find("views disagree"), std::string::npos)
        << fit->misfit;
  }
}

// Corners as the finder gives them: some are worth much less than others, and it says so but for a
// factor, and for what the lens leaves of all of them.
std::vector<PmdBoardView> uneven_views(const FixedPair& pair, std::uint64_t seed) {
  constexpr double kTold = 0.5;    // of what they scatter
  constexpr double kFloor = 0.02;  // px
  Gaussian random(seed + 500);
  std::vector<PmdBoardView> found = views(pair, seed);
  const std::vector<PmdBoardView> exact = views(pair, seed, 0);
  for (std::size_t n = 0; n < found.size(); ++n) {
    const double far = random.between(0.02, 0.2);
    for (std::size_t i = 0; i < found[n].pmd.size(); ++i) {
      const double u = far * random.between(0.5, 1.5);
      const double v = far * random.between(0.5, 1.5);
      const PixelPoint& truth = exact[n].pmd[i];
      found[n].pmd[i] = {.u = truth.u + random.next(u) + random.next(kFloor),
                         .v = truth.v + random.next(v) + random.next(kFloor),
                         .uu = kTold * kTold * u * u,
                         .vv = kTold * kTold * v * v};
    }
  }
  return found;
}

TEST(BoardExtrinsics, CornersCountByTheirOwnCovariances) {
  constexpr int kSeeds = 20;
  const FixedPair pair = raw_pair();
  double mean = 0;
  double volume = 0;  // the logarithm of the ellipsoid's, against that of corners that count alike
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    std::vector<PmdBoardView> uneven = uneven_views(pair, seed);
    const std::optional<ExtrinsicFit> fit = fit_extrinsics(kBoard, uneven, pair, kPmd);
    for (PmdBoardView& view : uneven) {
      for (PixelPoint& corner : view.pmd) {
        corner.uu = corner.vv = 1;
      }
    }
    const std::optional<ExtrinsicFit> alike = fit_extrinsics(kBoard, uneven, pair, kPmd);
    ASSERT_TRUE(fit && alike) << seed;
    const Eigen::Matrix<double, 6, 1> off = difference(fit->pmd_to_stereo, kTruth);
    mean += off.dot(fit->covariance.inverse() * off) / kSeeds;
    volume += std::log(fit->covariance.determinant() / alike->covariance.determinant()) / kSeeds;
  }
  std::printf(
      "figure: uneven corners: mean NEES %.2f of 20 seeds, ellipsoid's axes %.2f of those of "
      "corners that count alike\n",
      mean, std::exp(volume / 12));
  // Of 20 seeds the mean scatters by 0.8.
  EXPECT_GT(mean, 4.4);
  EXPECT_LT(mean, 7.6);
  EXPECT_LT(std::exp(volume / 12), 0.8);
}

TEST(BoardExtrinsics, FourViewsAreTooFew) {
  const FixedPair pair = raw_pair();
  std::vector<PmdBoardView> few = views(pair, 1);
  few.resize(4);
  EXPECT_FALSE(fit_extrinsics(kBoard, few, pair, kPmd));
}

TEST(BoardExtrinsics, CornersAreFoundInAnAmplitudePicture) {
  Gaussian random(3);
  const test::PlaneCamera camera(kPmd);
  const PoseUnknowns pose = test::board_at(kBoard, Vector3(0, 0, 1.1), Vector3(0.3, 0.2, 0.1));
  const dataset::Image<std::uint8_t> grey =
      camera.picture(pose, test::chessboard(kBoard), 1, random);
  dataset::Image<float> amplitude(grey.width, grey.height);
  std::ranges::transform(grey.pixels, amplitude.pixels.begin(),
                         [](std::uint8_t p) { return 3.0F * static_cast<float>(p); });
  const std::vector<PixelPoint> found = corners_in_amplitude(amplitude, kPmd, kBoard);
  const std::vector<PixelPoint> truth = test::seen_by(kPmd, pose, kBoard, 0, random);
  ASSERT_EQ(found.size(), truth.size());
  // Squares are 9 px wide here.
  double squares = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    squares += std::pow(found[i].u - truth[i].u, 2) + std::pow(found[i].v - truth[i].v, 2);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(2 * truth.size())), 0.1);
}

TEST(BoardExtrinsics, AnAmplitudePictureWithoutTheWholeBoardHasNoCorners) {
  Gaussian random(4);
  EXPECT_TRUE(corners_in_amplitude(dataset::Image<float>(64, 16), kPmd, kBoard).empty());  // dark
  EXPECT_TRUE(
      corners_in_amplitude(dataset::Image<float>(64, 16, 90.0F), kPmd, kBoard).empty());  // lit
  const test::PlaneCamera camera(kPmd);
  const PoseUnknowns cut = test::board_at(kBoard, Vector3(0.45, 0, 1.1), Vector3(0.3, 0.2, 0.1));
  const dataset::Image<std::uint8_t> grey =
      camera.picture(cut, test::chessboard(kBoard), 1, random);
  dataset::Image<float> amplitude(grey.width, grey.height);
  std::ranges::copy(grey.pixels, amplitude.pixels.begin());
  EXPECT_TRUE(corners_in_amplitude(amplitude, kPmd, kBoard).empty());
}

}  // namespace
}  // namespace stof::host
