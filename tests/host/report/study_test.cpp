#include "host/report/stereo/study.h"

#include <limits>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

dataset::Image<float> row(const std::vector<float>& values) {
  dataset::Image<float> image(static_cast<int>(values.size()), 1);
  image.pixels = values;
  return image;
}

TEST(Removal, SharesAreOfThePixelsThatHadADisparityAndTruth) {
  const dataset::Image<float> truth = row({5, 5, 5, 5, 5, 5, kNone});
  const dataset::Image<float> before = row({5, 5, 9, 9, 9, kNone, 5});
  const dataset::Image<float> after = row({5, kNone, kNone, kNone, 9, kNone, kNone});
  const Removal gone = removal(before, after, truth);
  EXPECT_DOUBLE_EQ(gone.removed, 3.0 / 5);
  EXPECT_DOUBLE_EQ(gone.wrong_of_removed.value(), 2.0 / 3);
  EXPECT_DOUBLE_EQ(gone.removed_of_wrong.value(), 2.0 / 3);
  EXPECT_DOUBLE_EQ(gone.removed_of_right.value(), 1.0 / 2);
  EXPECT_DOUBLE_EQ(gone.wrong_before.value(), 3.0 / 5);
  EXPECT_DOUBLE_EQ(gone.wrong_after.value(), 1.0 / 2);
  EXPECT_EQ(removed_pixels(before, after, truth).pixels,
            (std::vector<Finding>{Finding::kRight, Finding::kWronglyRemoved,
                                  Finding::kRightlyRemoved, Finding::kRightlyRemoved,
                                  Finding::kRight, Finding::kMissing, Finding::kUnknown}));
}

TEST(Removal, OfNothingHasNoShares) {
  const Removal gone = removal(row({5}), row({5}), row({5}));
  EXPECT_EQ(gone.removed, 0);
  EXPECT_FALSE(gone.wrong_of_removed.has_value());
  EXPECT_FALSE(gone.removed_of_wrong.has_value());
}

TEST(Subject, IsDrawnInTheRangeOfItsTruthElseOfTheSearch) {
  dataset::StereoScene scene;
  scene.left = {3, 1};
  scene.ndisp = 32;
  EXPECT_EQ(Subject(scene).scale.far_px, 0);
  EXPECT_EQ(Subject(scene).scale.near_px, 31);
  scene.truth = row({4.25F, kNone, 9.5F});
  EXPECT_EQ(Subject(scene).scale.far_px, 4);
  EXPECT_EQ(Subject(scene).scale.near_px, 10);
}

TEST(Study, NotesWhatTheMatcherRefuses) {
  dataset::StereoScene scene;
  scene.left = {8, 4};
  scene.right = {8, 4};
  scene.ndisp = 4;
  Study study({}, std::nullopt, 1, true);
  EXPECT_FALSE(study.run(scene, {"too large", block_match(scene, lab::Cost::kSad, 65, 1, true)}));
  EXPECT_TRUE(study.run(scene, {"fine", block_match(scene, lab::Cost::kSad, 3, 3, true)}));
  EXPECT_EQ(study.refused(), std::set<std::string>{"too large"});
}

}  // namespace
}  // namespace stof::host
