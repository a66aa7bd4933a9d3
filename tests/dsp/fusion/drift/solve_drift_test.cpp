#include "dsp/fusion/drift/solve_drift.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/index.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kColumns = 16;
constexpr int kRows = 12;
constexpr double kFrames = 50;
constexpr double kVariance = 1e-3;  // of one frame, px^2
constexpr DriftVector kTruth{0.002, -0.003, 0.001, 0.02, 0.01};

// What patches say after kFrames, each of slope(column, row).
class Patches {
 public:
  template <typename Slope>
  explicit Patches(Slope slope) {
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        DriftVector at = slope(x, y);
        at.back() = 1;
        double error = 0;
        for (std::size_t k = 0; k < at.size(); ++k) {
          error += at[k] * kTruth[k];
        }
        DriftPatch patch;
        for (int frame = 0; frame < kFrames; ++frame) {
          patch.add(error, at, kVariance);
        }
        patches_.push_back(patch);
      }
    }
  }
  DriftPatch& at(int x, int y) { return patches_[index(y * kColumns + x)]; }
  std::optional<DriftSolution> solve() {
    std::vector<double> trust(patches_.size());
    std::vector<double> sorted(patches_.size());
    return solve_drift(
        {.patches = patches_, .columns = kColumns, .trust = trust, .sorted = sorted});
  }

 private:
  std::vector<DriftPatch> patches_;
};

// Slopes of a scene of many planes, px a unit.
DriftVector usual(int x, int y) {
  test::Random random(static_cast<std::uint64_t>(y * kColumns + x));
  const auto some = [&] { return static_cast<double>(random.between(-400, 400)); };
  return {some(), some(), some(), some() / 10, 1};
}

TEST(SolveDrift, FindsWhatPatchesAgreeOn) {
  const std::optional<DriftSolution> found = Patches(usual).solve();
  ASSERT_TRUE(found);
  for (std::size_t k = 0; k < kDriftParameters; ++k) {
    EXPECT_NEAR(found->value[k], kTruth[k], 0.01 * std::abs(kTruth[k])) << k;
    EXPECT_GT(found->sigma[k], 0) << k;
  }
}

TEST(SolveDrift, ParametersThatLookAlikeToAllPatchesAreNotTold) {
  EXPECT_FALSE(Patches([](int x, int y) {
                 DriftVector at = usual(x, y);
                 at[0] = at[1] = 1e9 * at[0];
                 return at;
               }).solve());
}

// All together can be solved; what is left without the region is lost in its rounding.
TEST(SolveDrift, ARegionThatOutweighsAllOthersLeavesNothingToJudgeItBy) {
  EXPECT_FALSE(Patches([](int x, int y) {
                 DriftVector at = usual(x, y);
                 for (double& slope : at) {
                   slope *= x < kColumns / 4 && y < kColumns / 4 ? 1e9 : 1;
                 }
                 return at;
               }).solve());
}

TEST(SolveDrift, APatchWithoutNumbersIsLeftOut) {
  Patches without(usual);
  without.at(3, 4) = {};
  const std::optional<DriftSolution> expected = without.solve();
  ASSERT_TRUE(expected);
  for (const double hostile :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Patches patches(usual);
    patches.at(3, 4).slope[1] = hostile;
    const std::optional<DriftSolution> found = patches.solve();
    ASSERT_TRUE(found) << hostile;
    EXPECT_EQ(found->value, expected->value) << hostile;
    EXPECT_EQ(found->sigma, expected->sigma) << hostile;
  }
}

// All patches err by 0.1 px, up where `where` says.
template <typename Slope, typename Where>
DriftSolution with_errors(Slope slope, Where where) {
  Patches patches(slope);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      DriftPatch& patch = patches.at(x, y);
      patch.error += (where(x, y) ? 0.1 : -0.1) * patch.weight();
    }
  }
  return patches.solve().value();
}

// Frames of doors, a skirting: each square of the picture has as much of one as of the other.
TEST(SolveDrift, WhatStandsOrLiesThroughThePictureIsOneThing) {
  const auto offset = static_cast<std::size_t>(DriftParameter::kDisparity);
  const auto sigma = [](auto where) { return with_errors(usual, where).sigma[offset]; };
  const double apart = sigma([](int x, int y) { return (x + y) % 2 == 0; });
  EXPECT_GT(sigma([](int x, int) { return x / 2 % 2 == 0; }), 2 * apart);
  EXPECT_GT(sigma([](int, int y) { return y / 2 % 2 == 0; }), 2 * apart);
}

TEST(SolveDrift, NumbersTooLargeForASumAreNotSolved) {
  Patches patches(usual);
  patches.at(3, 4).slope[1] = 1e200;
  EXPECT_FALSE(patches.solve());
}

TEST(SolveDrift, WhatWasSeenOnceSaysNothing) {
  Patches patches(usual);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      patches.at(x, y) = {};
      patches.at(x, y).add(1, usual(x, y), kVariance);
      EXPECT_FALSE(patches.at(x, y).known());
    }
  }
  const std::optional<DriftSolution> found = patches.solve();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->value, DriftVector{});
}

}  // namespace
}  // namespace stof::dsp
